"""Shape features of a solid: cavities, openings, support surfaces, resting planes, protrusions, symmetry.

Read `heightfield.py` and `cavities.py` first; each `find_...` takes a `Solid` (metres, z up where it matters).
"""
