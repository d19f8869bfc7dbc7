"""Tests of the judge of appearance."""
