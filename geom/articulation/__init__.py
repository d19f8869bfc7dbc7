"""Geometry of joints: where a moved link lies against the rest, when it is shut, where to grip it, what it sweeps."""
