"""Tests of `assetkit.geometry`."""
