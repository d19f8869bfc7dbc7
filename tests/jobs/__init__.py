"""Tests of `jobs`: cells, folder lock, scheduling."""
