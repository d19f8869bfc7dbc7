"""Tests of `assetkit.readers`."""
