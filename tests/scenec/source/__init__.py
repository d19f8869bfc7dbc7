"""Tests of `scenec.source`."""
