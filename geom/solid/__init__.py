"""Physical solids from visual surfaces: closed bodies, open parts, thickened sheets, self-intersections, volume shares.

Read `solidify.py` first: it chooses between the methods of the others.
"""
