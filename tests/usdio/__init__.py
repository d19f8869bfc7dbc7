"""Tests of `usdio`."""
