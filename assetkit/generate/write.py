"""Writes generated objects as source files: a description with meshes per object, and `truth.json` for the set.

The description is URDF, or MJCF for an object with a spring, which URDF has no word for. Every link has one visual mesh
per part, primitive or convex collision shapes, and an inertial. Same set, same bytes.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import formats
from assetkit.generate.generator import COLOURS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import parameters_of
from assetkit.generate.truth import TRUTH_FILE, GeneratedTruth, TrueJoint, TrueLink, TrueObject, TrueParameter
from assetkit.package.write_obj import write_obj
from assetkit.package.write_twins import described_joint
from assetkit.package.write_urdf import described_collision
from geom.pose import pose
from schemas.anchors import Point3
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.physics import CollisionShape
from schemas.robot_description import (
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    Inertial,
    MeshReference,
    RobotDescription,
)

MESHES = "meshes"  # folder of mesh files, beside the descriptions


def write_set(generator: Generator[Any], values: Any, folder: Path, name: str | None = None) -> tuple[Path, ...]:
    """Write the objects that `generator` makes of `values` to `folder`, with `truth.json`; returns the descriptions.

    With `name` the one object is called so, several have it before their names. Raises ParameterError.
    """
    generated = generator.run(values)
    (folder / MESHES).mkdir(parents=True, exist_ok=True)
    named = tuple(centred(_named(thing, name, len(generated.objects))) for thing in generated.objects)
    files = [write_object(thing, folder) for thing in named]
    truth = GeneratedTruth(
        generator=generator.name,
        parameters={
            p.name: TrueParameter(value=getattr(values, p.name), unit=p.unit) for p in parameters_of(type(values))
        },
        objects=tuple(truth_of(thing, file.name) for thing, file in zip(named, files, strict=True)),
        clearances=_renamed(generated, named),
    )
    (folder / TRUTH_FILE).write_text(truth.model_dump_json(indent=1) + "\n")
    return tuple(files)


def write_object(thing: GeneratedObject, folder: Path) -> Path:
    """Write one object as `<folder>/<name>.urdf` or `.xml` with its files in `<folder>/meshes/`."""
    description = _description(thing, folder)
    has_spring = any(joint.stiffness for joint in thing.joints)
    written = formats.write_mjcf(description) if has_spring else formats.write_urdf(description)
    if written.lost:
        raise AssertionError(f"{thing.name}: {written.lost[0].headline}")
    path = folder / f"{thing.name}{'.xml' if has_spring else '.urdf'}"
    path.write_bytes(written.data)
    return path


def centred(thing: GeneratedObject) -> GeneratedObject:
    """The same object with the bottom centre of its bounding box at the origin: the asset frame."""
    points = np.concatenate([part.shape.surface[0] for link in thing.links for part in link.parts])
    low, high = points.min(axis=0), points.max(axis=0)
    shift = -np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])

    def at(point: Point3) -> Point3:
        return _point(np.asarray(point) + shift)

    return replace(
        thing,
        links=tuple(
            replace(link, parts=tuple(replace(part, shape=part.shape.moved(shift)) for part in link.parts))
            for link in thing.links
        ),
        joints=tuple(replace(joint, anchor=joint.anchor + shift) for joint in thing.joints),
        interiors=tuple(i.model_copy(update={"low_m": at(i.low_m), "high_m": at(i.high_m)}) for i in thing.interiors),
        holes=tuple(hole.model_copy(update={"centre_m": at(hole.centre_m)}) for hole in thing.holes),
    )


def truth_of(thing: GeneratedObject, file: str) -> TrueObject:
    """What is known about an object, which is written to `file`."""
    return TrueObject(
        name=thing.name,
        file=file,
        links=tuple(_true_link(link) for link in thing.links),
        joints=tuple(_true_joint(joint) for joint in thing.joints),
        interiors=thing.interiors,
        holes=thing.holes,
    )


def mechanism_of(thing: GeneratedObject) -> Mechanism:
    """How its links move; the frame of a link lies on the axis of its joint."""
    anchors = {joint.child: joint.anchor for joint in thing.joints}
    links = tuple(MechanismLink(link.name, anchors.get(link.name, np.zeros(3))) for link in thing.links)
    return Mechanism(links, thing.joints)


def _named(thing: GeneratedObject, name: str | None, count: int) -> GeneratedObject:
    if name is None:
        return thing
    return replace(thing, name=name if count == 1 else f"{name}_{thing.name}")


def _renamed(generated: GeneratedSet, named: tuple[GeneratedObject, ...]) -> tuple[Any, ...]:
    """The clearances between the objects under their names in files."""
    names = {old.name: new.name for old, new in zip(generated.objects, named, strict=True)}
    return tuple(
        c.model_copy(update={"inner": names.get(c.inner, c.inner), "outer": names.get(c.outer, c.outer)})
        for c in generated.clearances
    )


def _description(thing: GeneratedObject, folder: Path) -> RobotDescription:
    mechanism = mechanism_of(thing)
    origins = {link.name: link.origin for link in mechanism.links}
    links = tuple(_link(link, origins[link.name], thing.name, folder) for link in thing.links)
    joints = tuple(described_joint(joint, mechanism) for joint in thing.joints)
    return RobotDescription(thing.name, "urdf", links, joints, mechanism.root.name)


def _link(link: GeneratedLink, origin: FloatArray, object_name: str, folder: Path) -> DescribedLink:
    visuals = [_visual(part, shape_name(link, part), origin, object_name, folder) for part in link.parts]
    pieces = [piece for part in link.parts for piece in part.shape.convex]
    names = [f"{object_name}_{link.name}_collision_{i:02d}" for i in range(len(pieces))]
    collisions = [
        described_collision(name, _from_origin(piece, origin), folder, mesh_name=name)
        for name, piece in zip(names, pieces, strict=True)
    ]
    mass = link.mass
    inertial = Inertial(mass.mass_kg, pose(None, mass.centre_of_mass_m - origin), mass.inertia_kgm2)
    return DescribedLink(link.name, (*visuals, *collisions), inertial, "declared")


def shape_name(link: GeneratedLink, part: GeneratedPart) -> str:
    """The name of a part in the description, unique there: MJCF refuses a name twice."""
    return link.name if link.name.startswith(part.name) else f"{link.name}_{part.name}"


def _visual(part: GeneratedPart, name: str, origin: FloatArray, object_name: str, folder: Path) -> DescribedShape:
    points, triangles = part.shape.surface
    file = f"{MESHES}/{object_name}_{name}.obj"
    write_obj(folder / file, points - origin, triangles)
    material = DescribedMaterial(f"{part.colour}_{part.material}", (*COLOURS[part.colour], 1.0))
    reference = MeshReference(file, name=f"{object_name}_{name}")
    return DescribedShape(name, "mesh", (), np.eye(4), False, True, mesh=reference, material=material)


def _from_origin(piece: CollisionShape, origin: FloatArray) -> CollisionShape:
    """The shape in the frame of its link: corners of a hull are shifted, so that its frame is that of the link."""
    if piece.points is not None:
        return replace(piece, points=piece.points - origin)
    return replace(piece, X_AS=pose(None, -origin) @ piece.X_AS)


def _true_link(link: GeneratedLink) -> TrueLink:
    mass = link.mass
    ixx, ixy, ixz = (_point(row) for row in mass.inertia_kgm2)
    return TrueLink(
        name=link.name,
        volume_m3=sum(part.shape.volume.volume_m3 for part in link.parts),
        mass_kg=mass.mass_kg,
        centre_of_mass_m=_point(mass.centre_of_mass_m),
        inertia_kgm2=(ixx, ixy, ixz),
    )


def _true_joint(joint: MechanismJoint) -> TrueJoint:
    return TrueJoint(
        name=joint.name,
        kind=joint.kind,
        parent=joint.parent,
        child=joint.child,
        anchor_m=_point(joint.anchor),
        axis=_point(joint.axis),
        limits=joint.limits,
        damping=joint.damping,
        friction=joint.friction,
        stiffness=joint.stiffness,
        spring_rest=joint.spring_rest,
    )


def _point(values: FloatArray) -> Point3:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
