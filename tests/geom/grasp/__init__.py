"""Tests of `geom.grasp`."""
