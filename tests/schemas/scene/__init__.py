"""Tests of the scene schemas."""
