"""Tests of `mana task`."""
