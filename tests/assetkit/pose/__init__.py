"""Tests of `assetkit.pose`."""
