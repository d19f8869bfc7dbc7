"""Tests of `geom.mesh`."""
