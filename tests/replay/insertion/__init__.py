"""Tests of `replay.insertion`."""
