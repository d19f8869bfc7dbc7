"""Tests of `simgap.kinds.free_body`."""
