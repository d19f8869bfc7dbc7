"""Benchmarks of the asset pipeline; each prints the figures of docs/benchmarks.md."""
