"""Suites with a truth of their own: hidden effects, seeded gate defects, a second engine."""
