"""Tests of `assetkit.readers.gltf.read`."""
