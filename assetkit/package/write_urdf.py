"""Writes the URDF twin of a package (link, inertial, visuals, collisions; SI units) for PyBullet and ROS users."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import Float32Array, FloatArray, IntArray
from schemas.model import Material, Mesh
from schemas.package import PackageContent
from schemas.physics import CollisionShape, Contact, RigidBody
from usdio.write.mesh_materials import MeshMaterial, materials_per_mesh

# The namespace that Drake's own files declare for their additions to URDF.
DRAKE = "http://drake.mit.edu"
ElementTree.register_namespace("drake", DRAKE)


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
    robot = ElementTree.Element("robot", name=content.asset_id)
    link = ElementTree.SubElement(robot, "link", name=body.name)
    _contact(link, body)
    _inertial(link, body)
    mesh_materials = materials_per_mesh(content.model)
    for mesh, mesh_material in zip(content.model.meshes_by_id.values(), mesh_materials, strict=True):
        if len(mesh.triangles):
            _visual(link, mesh, mesh_material, export)
    contacts = shape_contacts if len(set(shape_contacts)) > 1 else [None] * len(body.shapes)
    for index, (shape, contact) in enumerate(zip(body.shapes, contacts, strict=True)):
        collision = _collision(link, f"collider_{index:02d}", shape, export)
        if contact is not None:
            _proximity(collision, contact)
    path = export / f"{content.asset_id}.urdf"
    _save(robot, path)
    return path


def rewrite_urdf(
    body: RigidBody, path: Path, contact: Mapping[str, float], shape_contacts: Sequence[Contact] = ()
) -> None:
    """Give the one link of a twin the mass, inertia and friction of `body`, and further children of `<contact>`; the
    shapes `shape_contacts` where they have contacts of their own.
    """
    robot = ElementTree.parse(path).getroot()
    link = robot.find("link")
    if link is None:
        raise ValueError(f"{path.name} has no link")
    for old in (*link.findall("contact"), *link.findall("inertial")):
        link.remove(old)
    fresh = ElementTree.Element("link")
    _contact(fresh, body)
    _inertial(fresh, body)
    for name, value in contact.items():
        ElementTree.SubElement(fresh[0], name, value=_text(value))
    link[:0] = list(fresh)
    for collision, shape_contact in zip(link.findall("collision"), shape_contacts, strict=False):
        for old in collision.findall(f"{{{DRAKE}}}proximity_properties"):
            collision.remove(old)
            _proximity(collision, shape_contact)
    _save(robot, path)


def _save(robot: ElementTree.Element, path: Path) -> None:
    ElementTree.indent(robot, "  ")
    path.write_bytes(ElementTree.tostring(robot, xml_declaration=True, encoding="utf-8"))


def _contact(link: ElementTree.Element, body: RigidBody) -> None:
    contact = ElementTree.SubElement(link, "contact")
    ElementTree.SubElement(contact, "lateral_friction", value=_text(body.contact.dynamic_friction))
    ElementTree.SubElement(contact, "restitution", value=_text(body.contact.restitution))


def _inertial(link: ElementTree.Element, body: RigidBody) -> None:
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_texts(body.mass.centre_of_mass_m), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=_text(body.mass.mass_kg))
    inertia = body.mass.inertia_kgm2
    entries = {f"i{'xyz'[i]}{'xyz'[j]}": _text(inertia[i, j]) for i in range(3) for j in range(i, 3)}
    ElementTree.SubElement(inertial, "inertia", entries)


def _visual(link: ElementTree.Element, mesh: Mesh, mesh_material: MeshMaterial, export: Path) -> None:
    visual = ElementTree.SubElement(link, "visual", name=mesh.id)
    ElementTree.SubElement(visual, "origin", xyz="0 0 0", rpy="0 0 0")
    file, uvs = f"visual_{mesh.id}.obj", mesh.uvs[0] if mesh.uvs else None
    _write_obj(export / "meshes" / file, mesh.points, mesh.triangles, uvs)
    _mesh_element(visual, file)
    material = ElementTree.SubElement(visual, "material", name=mesh_material.prim_name)
    ElementTree.SubElement(
        material, "color", rgba=_texts((*_srgb(mesh_material.material), mesh_material.material.opacity))
    )


def _proximity(collision: ElementTree.Element, contact: Contact) -> None:
    properties = ElementTree.SubElement(collision, f"{{{DRAKE}}}proximity_properties")
    ElementTree.SubElement(properties, f"{{{DRAKE}}}mu_static", value=_text(contact.static_friction))
    ElementTree.SubElement(properties, f"{{{DRAKE}}}mu_dynamic", value=_text(contact.dynamic_friction))


def _collision(link: ElementTree.Element, name: str, shape: CollisionShape, export: Path) -> ElementTree.Element:
    collision = ElementTree.SubElement(link, "collision", name=name)
    rpy = Rotation.from_matrix(shape.X_AS[:3, :3]).as_euler("xyz")  # URDF: fixed axes x, y, z
    ElementTree.SubElement(collision, "origin", xyz=_texts(shape.X_AS[:3, 3]), rpy=_texts(rpy))
    if shape.kind == "hull":
        if shape.points is None or shape.triangles is None:
            raise ValueError("a hull shape needs points and triangles")
        _write_obj(export / "meshes" / f"{name}.obj", shape.points, shape.triangles)
        _mesh_element(collision, f"{name}.obj")
        return collision
    geometry = ElementTree.SubElement(collision, "geometry")
    if shape.kind == "box":
        ElementTree.SubElement(geometry, "box", size=_texts(shape.size_m))
    elif shape.kind == "sphere":
        ElementTree.SubElement(geometry, "sphere", radius=_text(shape.size_m[0]))
    else:
        ElementTree.SubElement(geometry, shape.kind, radius=_text(shape.size_m[0]), length=_text(shape.size_m[1]))
    return collision


def _mesh_element(parent: ElementTree.Element, file: str) -> None:
    ElementTree.SubElement(ElementTree.SubElement(parent, "geometry"), "mesh", filename=f"meshes/{file}", scale="1 1 1")


def _write_obj(path: Path, points: FloatArray, triangles: IntArray, uvs: Float32Array | None = None) -> None:
    """A Wavefront OBJ whose numbers read back exactly: the shortest decimal that gives the same double."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, dtype=np.float64).tolist()]
    corners = (np.asarray(triangles, dtype=np.int64) + 1).tolist()
    if uvs is None:
        lines += [f"f {a} {b} {c}" for a, b, c in corners]
    else:
        lines += [f"vt {u!r} {v!r}" for u, v in uvs.reshape(-1, 2).tolist()]
        lines += [f"f {a}/{3 * i + 1} {b}/{3 * i + 2} {c}/{3 * i + 3}" for i, (a, b, c) in enumerate(corners)]
    path.write_text("\n".join(lines) + "\n")


def _srgb(material: Material) -> FloatArray:
    """Display colour of the linear base colour (IEC 61966-2-1), which is what URDF viewers expect."""
    linear = np.clip(np.asarray(material.base_color, dtype=np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def _text(value: float) -> str:
    return repr(float(value))


def _texts(values: Iterable[float]) -> str:
    return " ".join(_text(value) for value in values)
