"""Tests of `assetkit`."""
