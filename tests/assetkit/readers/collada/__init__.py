"""Tests of `assetkit.readers.collada`."""
