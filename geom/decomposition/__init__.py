"""Convex decomposition of a solid: simplification, cutting planes, merging, trimming and offsetting of hulls, fidelity.

Read `decompose.py` first: it calls the steps in order.
"""
