"""Helpers of tests: samples, generators, small libraries of packages and scenes."""
