"""Tests of `simgap.kinds`."""
