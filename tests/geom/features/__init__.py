"""Tests of `geom.features`."""
