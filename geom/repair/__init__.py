"""Repairs of triangle meshes: boundary loops, holes, T-junctions, winding, duplicate shells, and the change they
make.
"""
