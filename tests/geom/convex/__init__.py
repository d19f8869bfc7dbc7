"""Tests of `geom.convex`."""
