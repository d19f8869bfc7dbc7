"""Tests of `assetkit.affordances.regions`."""
