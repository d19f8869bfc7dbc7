"""Tests of `assetkit.physics`."""
