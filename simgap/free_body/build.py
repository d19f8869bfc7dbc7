"""The body as its owner believes it, from the subject of a measurement."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from geom.hull import hull_shape
from schemas.measurement import MeasurementSpec
from schemas.physics import CollisionShape
from sim.body_replay import BodyModel


def build_body(spec: MeasurementSpec, root: Path) -> BodyModel:
    """The declared model of a `free_body` measurement.

    A mesh counts as its convex hull. A missing inertia is that of the shape filled evenly. Raises ValueError when the
    subject has no shape or no mass.
    """
    subject, world = spec.subject, spec.world
    if subject.mass_kg is None:
        raise ValueError("the subject declares no mass_kg")
    shapes = _shapes(spec, root)
    com = np.array(subject.com_m)
    inertia = (
        np.diag(subject.inertia_kgm2) if subject.inertia_kgm2 is not None else _even_inertia(shapes, subject.mass_kg)
    )
    support = world.support
    normal = np.array(support.plane.normal if support else (0.0, 0.0, 1.0), dtype=float)
    return BodyModel(
        shapes=shapes,
        mass_kg=subject.mass_kg,
        com_B=com,
        inertia_B=inertia,
        friction=subject.contact.friction,
        restitution=subject.contact.restitution,
        gravity_W=np.array(world.gravity_mps2),
        plane_normal_W=normal / np.linalg.norm(normal),
        plane_height_m=support.plane.height_m if support else 0.0,
        has_support=support is not None,
    )


def _shapes(spec: MeasurementSpec, root: Path) -> tuple[CollisionShape, ...]:
    subject = spec.subject
    if subject.box is not None:
        return (CollisionShape("box", subject.box.size_m, np.eye(4)),)
    if subject.mesh is not None:
        mesh = trimesh.load_mesh(root / subject.mesh, process=False)
        shape = hull_shape(np.asarray(mesh.vertices, dtype=float))
        if shape is None:
            raise ValueError(f"{subject.mesh} has no volume")
        return (shape,)
    raise ValueError("the subject has neither box nor mesh")


def _even_inertia(shapes: tuple[CollisionShape, ...], mass_kg: float) -> np.ndarray:
    """Inertia (3, 3) of the first shape filled evenly."""
    shape = shapes[0]
    if shape.kind == "box":
        x, y, z = shape.size_m
        return mass_kg / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    hull = trimesh.Trimesh(shape.points, shape.triangles, process=False)
    hull.density = mass_kg / hull.volume
    return np.asarray(hull.moment_inertia)
