"""Tests of `replay.recording`."""
