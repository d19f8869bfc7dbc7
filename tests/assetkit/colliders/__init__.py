"""Tests of `assetkit.colliders.choose`."""
