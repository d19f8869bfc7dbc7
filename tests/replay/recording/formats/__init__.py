"""Tests of `replay.recording.formats`."""
