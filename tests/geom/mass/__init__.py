"""Tests of `geom.mass`."""
