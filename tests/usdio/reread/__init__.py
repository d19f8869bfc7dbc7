"""Tests of `usdio.reread.body`."""
