"""Tests of YAML trees with positions."""
