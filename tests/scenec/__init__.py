"""Tests of `scenec`."""
