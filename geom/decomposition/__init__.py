"""Convex decomposition of a solid: simplification, cutting planes, merging and trimming of hulls, fidelity."""
