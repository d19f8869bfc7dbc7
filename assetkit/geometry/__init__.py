"""Helpers of the canonicalize stage: repairs of a mesh, its reference frame, its physical surface, its record
section.
"""
