"""Tests of `geom`."""
