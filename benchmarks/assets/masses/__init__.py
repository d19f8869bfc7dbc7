"""Benchmarks of mass estimates against stated and published masses."""
