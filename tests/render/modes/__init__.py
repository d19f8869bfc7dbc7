"""Tests of the modes in which objects are drawn."""
