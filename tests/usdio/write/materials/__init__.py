"""Tests of the shaders that are written for a material."""
