"""Tests of `scenec.pictures`: obstacles drawn in failure pictures."""
