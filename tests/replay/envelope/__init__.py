"""Tests of `replay.envelope.envelope`."""
