"""Tests of `assetkit.articulation`."""
