"""Tests of `assetkit.sources`."""
