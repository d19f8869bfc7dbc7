"""Benchmarks of the scene compiler."""
