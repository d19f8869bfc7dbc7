"""Tests of `cli.replay.app`."""
