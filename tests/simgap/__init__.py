"""Tests of `simgap`."""
