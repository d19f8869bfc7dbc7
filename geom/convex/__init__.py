"""Convex shapes: hulls, support functions, primitive fits, unions, penetration depth, scaling; read `hull` first."""
