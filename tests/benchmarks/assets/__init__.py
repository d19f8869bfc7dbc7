"""Tests of `benchmarks.assets.obj2mjcf.compare`."""
