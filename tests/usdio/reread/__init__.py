"""Tests of `usdio.reread`: packages read back from disk."""
