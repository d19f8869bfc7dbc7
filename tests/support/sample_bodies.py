"""Rigid bodies with known mass properties, standing on z = 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh

from geom.mass import inertia
from geom.pose import pose
from schemas.physics import CollisionShape, Contact, MassProperties, RigidBody

DENSITY = 1000.0


def contact(friction: float = 0.5, restitution: float = 0.0, **changes) -> Contact:
    return Contact(static_friction=friction, dynamic_friction=friction, restitution=restitution, **changes)


def box(size_m: Sequence[float], touch: Contact | None = None) -> RigidBody:
    return boxes([(size_m, (0.0, 0.0, size_m[2] / 2))], touch)


def boxes(parts: Sequence[tuple[Sequence[float], Sequence[float]]], touch: Contact | None = None) -> RigidBody:
    """A compound of (edge lengths, centre)."""
    shapes = tuple(
        CollisionShape("box", tuple(map(float, size)), pose(None, np.asarray(centre))) for size, centre in parts
    )
    masses = [inertia.moved(inertia.of_box(size, DENSITY), pose(None, np.asarray(centre))) for size, centre in parts]
    return RigidBody("boxes", shapes, inertia.combine(masses), touch or contact())


def sphere(radius: float, touch: Contact | None = None) -> RigidBody:
    return _primitive("sphere", (radius,), inertia.of_sphere(radius, DENSITY), radius, touch)


def cylinder(radius: float, height: float, touch: Contact | None = None) -> RigidBody:
    return _primitive("cylinder", (radius, height), inertia.of_cylinder(radius, height, DENSITY), height / 2, touch)


def capsule(radius: float, height: float) -> RigidBody:
    mass = inertia.of_capsule(radius, height, DENSITY)
    return _primitive("capsule", (radius, height), mass, height / 2 + radius, None)


def hull(mesh: trimesh.Trimesh, touch: Contact | None = None) -> RigidBody:
    """The convex `mesh`, moved to bottom centre."""
    low, high = mesh.bounds
    points = np.array(mesh.vertices) - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    triangles = np.array(mesh.faces, dtype=np.int32)
    shape = CollisionShape("hull", (), np.eye(4), points, triangles)
    return RigidBody("hull", (shape,), inertia.enclosed_volume(points, triangles).filled(DENSITY), touch or contact())


def hull_box(size_m: Sequence[float], touch: Contact | None = None) -> RigidBody:
    return hull(trimesh.creation.box(size_m), touch)


def _primitive(kind, size, mass: MassProperties, lift_m: float, touch: Contact | None) -> RigidBody:
    X_AS = pose(None, (0.0, 0.0, lift_m))
    shape = CollisionShape(kind, tuple(map(float, size)), X_AS)
    return RigidBody(kind, (shape,), inertia.moved(mass, X_AS), touch or contact())
