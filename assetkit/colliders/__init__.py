"""Collision shapes of one object: candidates from primitives to convex decompositions, and the choice among them."""
