"""Geometry processing on plain arrays: points (n, 3), triangles (m, 3), poses (4, 4); no files and no simulator.

Folders from the ground up: `mesh` (triangle surfaces), `mass`, `convex` and `repair`, then `solid` (closed bodies from
visual meshes), `features` (cavities, supports, holes), `decomposition` (convex parts) and `grasp`. First read `pose`.
"""
