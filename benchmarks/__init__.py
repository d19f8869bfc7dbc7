"""Measured tables. Run with `make bench`; figures go to docs/benchmarks.md."""
