"""Generators of the reference pages: diagnostics, gate rules, effects, formats (`make docs`)."""
