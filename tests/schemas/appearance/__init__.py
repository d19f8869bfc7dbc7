"""Tests of the optical model of a material."""
