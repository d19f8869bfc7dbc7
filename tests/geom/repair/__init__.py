"""Tests of `geom.repair`."""
