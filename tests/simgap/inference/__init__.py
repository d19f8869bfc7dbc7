"""Tests of `simgap.inference`."""
