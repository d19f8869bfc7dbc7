"""Tests of `assetkit.readers.obj.read`."""
