"""Triangle meshes as arrays: topology, edges, components, welding, editing, decimation, distances, rays, sections.

Read `edges.py` and `components.py` first: most of the other modules and all repairs build on them.
"""
