"""Tests of `geom.articulation`."""
