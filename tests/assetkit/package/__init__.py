"""Tests of `assetkit.package`."""
