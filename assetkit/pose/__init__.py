"""Orientation of one object: its up axis, its upright pose and its front."""
