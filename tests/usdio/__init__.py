"""Tests of `usdio`: reading, writing and re-reading of USD files."""
