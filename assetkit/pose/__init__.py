"""Orientation of one object: up axis of the source (`up_axis`), upright direction (`upright`) and front (`front`)."""
