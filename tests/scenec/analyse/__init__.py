"""Tests of `scenec.analyse`."""
