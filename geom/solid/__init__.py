"""Solids from surfaces: closed bodies, open parts, shells with thickness, self-intersections, volume shares."""
