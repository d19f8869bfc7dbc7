"""Tests of `assetkit.acceptance`."""
