"""Tests of `replay.recording.description`."""
