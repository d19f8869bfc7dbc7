"""Tests of `scenec.explain`."""
