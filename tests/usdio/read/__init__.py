"""Tests of `usdio.read`: meshes, materials, physics and the layer guard."""
