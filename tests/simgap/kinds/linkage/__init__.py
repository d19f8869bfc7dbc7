"""Tests of `simgap.kinds.linkage`."""
