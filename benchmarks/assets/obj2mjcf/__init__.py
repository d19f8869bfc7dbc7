"""Comparison of the pipeline with obj2mjcf on the same files."""
