"""Tests of `assetkit.scale`."""
