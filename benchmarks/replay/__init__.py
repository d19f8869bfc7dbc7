"""Benchmarks of replay augmentation."""
