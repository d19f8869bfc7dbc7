"""Tests of `scenec.pictures`."""
