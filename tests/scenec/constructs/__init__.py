"""Tests of single constructs of the scene language."""
