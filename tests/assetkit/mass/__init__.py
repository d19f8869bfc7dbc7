"""Tests of `assetkit.mass.estimate`."""
