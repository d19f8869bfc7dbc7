"""Scaled collision shapes."""

from __future__ import annotations

from dataclasses import replace

from schemas.physics import CollisionShape


def scaled(shape: CollisionShape, factor: float) -> CollisionShape:
    """The shape at `factor` times its size, about the origin of its frame of reference."""
    X = shape.X_AS.copy()
    X[:3, 3] *= factor
    points = None if shape.points is None else shape.points * factor
    return replace(shape, size_m=tuple(s * factor for s in shape.size_m), X_AS=X, points=points)
