"""Tests of the commands `mana assets ...`."""
