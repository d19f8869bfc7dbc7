"""Tests of single generators: what they build, by formulas written down by hand."""
