"""Tests of `assetkit.readers.ply.read`."""
