"""Rigid bodies that hold still relative to each other, as one rigid body."""

from __future__ import annotations

from collections.abc import Sequence

from geom.convex.placement import moved_shape
from geom.mass.inertia import combine, moved
from schemas.arrays import FloatArray
from schemas.physics import RigidBody


def one_body(name: str, placed: Sequence[tuple[RigidBody, FloatArray]]) -> RigidBody:
    """The bodies, each with X_AB (4, 4) of its frame, as one body in A; contact is that of the heaviest."""
    shapes = [moved_shape(shape, X_AB) for body, X_AB in placed for shape in body.shapes]
    mass = combine([moved(body.mass, X_AB) for body, X_AB in placed])
    heaviest = max((body for body, _ in placed), key=lambda body: body.mass.mass_kg)
    return RigidBody(name, tuple(shapes), mass, heaviest.contact)
