"""Tests of `assetkit.acceptance.suites`."""
