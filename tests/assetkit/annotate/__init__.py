"""Tests of `assetkit.annotate`."""
