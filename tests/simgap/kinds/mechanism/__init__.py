"""Tests of `simgap.kinds.mechanism`."""
