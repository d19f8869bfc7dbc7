"""Tests of `simgap.sanity`."""
