"""Tests of `mana pipeline`."""
