"""Collision shapes of one object: candidates from primitives to convex decompositions; read `choose` first."""
