"""Tests of `simgap.extension.extension`."""
