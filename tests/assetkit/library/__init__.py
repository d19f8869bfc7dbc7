"""Tests of `assetkit.library`."""
