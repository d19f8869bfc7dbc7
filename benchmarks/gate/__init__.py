"""Benchmarks of the plausibility gate: seeded defects and mutations."""
