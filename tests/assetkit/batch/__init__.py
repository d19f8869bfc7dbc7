"""Tests of `assetkit.batch`: decisions of people, applied to batches."""
