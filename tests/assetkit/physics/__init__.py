"""Tests of `assetkit.physics`: the physics section and its contact materials."""
