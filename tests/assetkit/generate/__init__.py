"""Tests of the generators of mechanisms and props."""
