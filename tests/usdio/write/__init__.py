"""Tests of `usdio.write`."""
