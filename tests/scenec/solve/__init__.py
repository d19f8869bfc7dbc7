"""Tests of `scenec.solve`."""
