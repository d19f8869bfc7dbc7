"""Tests of `assetkit.readers.blend`."""
