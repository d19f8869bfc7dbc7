"""Tests of `geom.decomposition`."""
