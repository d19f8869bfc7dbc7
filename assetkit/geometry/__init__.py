"""Geometry of the canonicalize stage: repairs, reference frame, physical surface, record section.

Start with `canonical_model`.
"""
