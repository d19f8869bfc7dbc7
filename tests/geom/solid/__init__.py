"""Tests of `geom.solid.solidify`."""
