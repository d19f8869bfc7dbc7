"""Uniform scaling of collision shapes and rigid bodies about the origin of their frame."""

from __future__ import annotations

from dataclasses import replace

from schemas.physics import CollisionShape, MassProperties, RigidBody


def scaled(shape: CollisionShape, factor: float) -> CollisionShape:
    """The shape at `factor` times its size, about the origin of its frame of reference."""
    X = shape.X_AS.copy()
    X[:3, 3] *= factor
    points = None if shape.points is None else shape.points * factor
    return replace(shape, size_m=tuple(s * factor for s in shape.size_m), X_AS=X, points=points)


def scaled_body(body: RigidBody, factor: float) -> RigidBody:
    """The body with shapes and mass centre scaled by `factor`; mass and inertia are unchanged."""
    mass = MassProperties(body.mass.mass_kg, body.mass.centre_of_mass_m * factor, body.mass.inertia_kgm2)
    return replace(body, shapes=tuple(scaled(shape, factor) for shape in body.shapes), mass=mass)
