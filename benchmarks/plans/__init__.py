"""Benchmarks of sampling plans against rejection samplers."""
