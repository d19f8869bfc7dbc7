"""Tests of `assetkit.readers.robot`."""
