"""Repairs of triangle meshes: boundary loops, holes, T-junctions, winding, duplicate shells, and the shape change.

Most functions take a welded `Mesh` and return the repaired one with its counts (`Figures`).
"""
