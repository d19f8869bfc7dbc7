"""Tests of `assetkit.parts`."""
