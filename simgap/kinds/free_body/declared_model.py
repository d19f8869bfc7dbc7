"""The declared body of a `free_body` measurement, built from its subject; SI, body frame B."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh

from geom.convex.hull import hull_shape
from geom.mass.inertia import scaled
from schemas.measurement import MeasurementSpec
from schemas.physics import CollisionShape, MassProperties
from sim.dynamics.body_rollout import BodyModel
from simgap.recording.reading.contact import with_declared_contact
from simgap.recording.reading.subject import read_subject
from simgap.recording.reading.urdf import SubjectLink


def build_body(spec: MeasurementSpec, root: Path) -> BodyModel:
    """The declared model of a `free_body` measurement without joints.

    A mesh counts as its convex hull; a URDF or a package brings all of its collision shapes. A missing inertia is that
    of the shape filled evenly. Raises ValueError when the subject has no shape or no mass.
    """
    subject = spec.subject
    if subject.urdf is not None or subject.package is not None:
        urdf = read_subject(subject, root)
        if urdf.joints:
            raise ValueError(
                f"the subject has joints, of which no column tells: {', '.join(j.name for j in urdf.joints)}"
            )
        return body_of(spec, urdf.links[0])
    if subject.mass_kg is None:
        raise ValueError("the subject declares no mass_kg")
    shapes = _shapes(spec, root)
    inertia = (
        np.diag(subject.inertia_kgm2) if subject.inertia_kgm2 is not None else _even_inertia(shapes, subject.mass_kg)
    )
    return _model(spec, shapes, MassProperties(subject.mass_kg, np.array(subject.com_m), inertia))


def body_of(spec: MeasurementSpec, link: SubjectLink) -> BodyModel:
    """A link of the subject's URDF as the body; values of `subject` override it. Raises ValueError without mass."""
    subject, mass = spec.subject, link.mass
    if subject.mass_kg is not None:
        known = mass or MassProperties(subject.mass_kg, np.array(subject.com_m), _even_inertia(link.shapes, 1.0))
        mass = scaled(known, subject.mass_kg / known.mass_kg)
    if mass is None:
        raise ValueError(f"link '{link.name}' has no mass, and the subject declares no mass_kg")
    if "com_m" in subject.model_fields_set:
        mass = replace(mass, centre_of_mass_m=np.array(subject.com_m))
    if subject.inertia_kgm2 is not None:
        mass = replace(mass, inertia_kgm2=np.diag(subject.inertia_kgm2))
    if not link.shapes and spec.world.support is not None:
        raise ValueError(f"link '{link.name}' has no collision shape")
    return _model(spec, link.shapes, mass, link)


def _model(
    spec: MeasurementSpec, shapes: tuple[CollisionShape, ...], mass: MassProperties, link: SubjectLink | None = None
) -> BodyModel:
    contact, world = spec.subject.contact, spec.world
    said = contact.model_fields_set
    friction, restitution = contact.friction, contact.restitution
    if link is not None:
        friction = link.friction if link.friction is not None and "friction" not in said else friction
        restitution = link.restitution if link.restitution is not None and "restitution" not in said else restitution
    support = world.support
    normal = np.array(support.plane.normal if support else (0.0, 0.0, 1.0), dtype=float)
    body = BodyModel(
        shapes=shapes,
        mass_kg=mass.mass_kg,
        com_B=mass.centre_of_mass_m,
        inertia_B=mass.inertia_kgm2,
        friction=friction,
        restitution=restitution,
        gravity_W=np.array(world.gravity_mps2),
        plane_normal_W=normal / np.linalg.norm(normal),
        plane_height_m=support.plane.height_m if support else 0.0,
        has_support=support is not None,
    )
    return with_declared_contact(body, contact)


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
