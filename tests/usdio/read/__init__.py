"""Tests of `usdio.read.asset`."""
