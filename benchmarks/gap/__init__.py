"""Benchmarks of the sim gap on public recordings."""
