"""Tests of `assetkit.batch`."""
