"""Tests of `scenec.check`."""
