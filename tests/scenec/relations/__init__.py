"""Tests of the relations of the scene language."""
