"""Tests of `assetkit.readers.common`."""
