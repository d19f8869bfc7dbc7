"""Tests of `assetkit.stages`."""
