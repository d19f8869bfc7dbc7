"""Tests of `simgap.recording.reading`."""
