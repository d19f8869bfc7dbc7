"""Tests of `usdio.write`: released packages and compiled scenes."""
