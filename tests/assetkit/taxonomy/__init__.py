"""Tests of `assetkit.taxonomy`."""
