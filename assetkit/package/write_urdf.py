"""Writes the URDF twin of a package (link, inertial, visuals, collisions; SI units) for PyBullet and ROS users."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

import formats
from assetkit.package.write_obj import write_obj
from formats.urdf.edit import replace_physics
from geom.pose import pose
from schemas.appearance.material import Material
from schemas.arrays import FloatArray
from schemas.model import Mesh
from schemas.package import PackageContent
from schemas.physics import CollisionShape, Contact, RigidBody
from schemas.robot_description import (
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    Inertial,
    MeshReference,
    RobotDescription,
    ShapeFriction,
)
from usdio.write.materials.mesh_materials import MeshMaterial, materials_per_mesh


def write_urdf(body: RigidBody, content: PackageContent, folder: Path, shape_contacts: Sequence[Contact] = ()) -> Path:
    """Write `<folder>/export/<asset_id>.urdf` with its OBJ files in `export/meshes/` and return it.

    Mass, inertia (full tensor about the mass centre, asset axes), shapes and friction are those of `body`, digit for
    digit; pass the body as re-read from the USD and the twin cannot differ. PyBullet users must load it with
    `URDF_USE_INERTIA_FROM_FILE`. `<contact>` is PyBullet's extension; its `lateral_friction` is the dynamic one.
    Other tools ignore it. A link has one friction there; where shapes differ (`shape_contacts`, one each) every
    `<collision>` also has its own in the way that Drake reads, `drake:proximity_properties`. `capsule` is read by
    PyBullet and newer URDF parsers only.
    """
    export = folder / "export"
    (export / "meshes").mkdir(parents=True, exist_ok=True)
    meshes = zip(content.model.meshes_by_id.values(), materials_per_mesh(content.model), strict=True)
    link = described_link(body, list(meshes), shape_contacts, export)
    path = export / f"{content.asset_id}.urdf"
    path.write_bytes(formats.write_urdf(RobotDescription(content.asset_id, "urdf", (link,), (), body.name)).data)
    return path


def described_link(
    body: RigidBody,
    meshes: Sequence[tuple[Mesh, MeshMaterial]],
    shape_contacts: Sequence[Contact],
    export: Path,
    prefix: str = "",
) -> DescribedLink:
    """The link of `body` with these visible meshes, both in its frame; their files are written to `export/meshes/`.

    Names of collision shapes and their files begin with `prefix`.
    """
    visuals = [_visual(mesh, material, export) for mesh, material in meshes if len(mesh.triangles)]
    contacts = shape_contacts if len(set(shape_contacts)) > 1 else [None] * len(body.shapes)
    collisions = [
        described_collision(f"{prefix}collider_{index:02d}", shape, export, contact and _friction(contact))
        for index, (shape, contact) in enumerate(zip(body.shapes, contacts, strict=True))
    ]
    return DescribedLink(body.name, (*visuals, *collisions), _inertial(body), "declared", _contact(body))


def rewrite_urdf(
    body: RigidBody, path: Path, contact: Mapping[str, float], shape_contacts: Sequence[Contact] = ()
) -> None:
    """Give the one link of a twin the mass, inertia and friction of `body`, and further children of `<contact>`; the
    shapes `shape_contacts` where they have contacts of their own.
    """
    frictions = tuple(_friction(shape_contact) for shape_contact in shape_contacts)
    path.write_bytes(replace_physics(path, _inertial(body), {**_contact(body), **contact}, frictions))


def _contact(body: RigidBody) -> dict[str, float]:
    return {"lateral_friction": body.contact.dynamic_friction, "restitution": body.contact.restitution}


def _friction(contact: Contact) -> ShapeFriction:
    return ShapeFriction(contact.static_friction, contact.dynamic_friction)


def _inertial(body: RigidBody) -> Inertial:
    return Inertial(body.mass.mass_kg, pose(None, body.mass.centre_of_mass_m), body.mass.inertia_kgm2)


def _visual(mesh: Mesh, mesh_material: MeshMaterial, export: Path) -> DescribedShape:
    file = f"visual_{mesh.id}.obj"
    write_obj(export / "meshes" / file, mesh.points, mesh.triangles, mesh.uvs[0] if mesh.uvs else None)
    red, green, blue = display_colour(mesh_material.material).tolist()
    material = DescribedMaterial(mesh_material.prim_name, (red, green, blue, mesh_material.material.opacity))
    reference = MeshReference(f"meshes/{file}")
    return DescribedShape(mesh.id, "mesh", (), np.eye(4), False, True, mesh=reference, material=material)


def described_collision(
    name: str, shape: CollisionShape, export: Path, friction: ShapeFriction | None = None, mesh_name: str = ""
) -> DescribedShape:
    """A collision shape in the frame of its link; the file of a hull is written to `export/meshes/`. `mesh_name` is
    what MJCF calls its mesh."""
    if shape.kind != "hull":
        return DescribedShape(name, shape.kind, shape.size_m, shape.X_AS, True, False, friction=friction)
    if shape.points is None or shape.triangles is None:
        raise ValueError("a hull shape needs points and triangles")
    write_obj(export / "meshes" / f"{name}.obj", shape.points, shape.triangles)
    reference = MeshReference(f"meshes/{name}.obj", name=mesh_name)
    return DescribedShape(name, "mesh", (), shape.X_AS, True, False, mesh=reference, friction=friction)


def display_colour(material: Material) -> FloatArray:
    """Display colour of the linear base colour (IEC 61966-2-1), which is what URDF viewers expect."""
    linear = np.clip(np.asarray(material.base_color, dtype=np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
