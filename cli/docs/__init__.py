"""Generators of the reference pages: diagnostics, gate rules, effects (`make docs`)."""
