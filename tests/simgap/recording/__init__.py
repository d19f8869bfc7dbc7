"""Tests of `simgap.recording`."""
