"""Writes a `RobotDescription` as MJCF: radians, quaternions, no classes; numbers read back as the same doubles.

A root that is not the world becomes a body welded to it. Mimics become joint equalities, and points that close loops
`connect` equalities between sites; MuJoCo keeps both softly. Meshes that do not collide are shells to MuJoCo: it
refuses flat ones as solids, whatever their mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from formats.losses import WrittenDescription, loss, not_expressible, unread_losses
from formats.tree import breadth_first, joints_of
from formats.xml_elements import Element
from formats.xml_text import element, number_text, numbers_text, to_bytes
from geom.pose import quat_of
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic
from schemas.robot_description import (
    WORLD_LINK,
    DescribedJoint,
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    Inertial,
    MeshReference,
    Mimic,
    RobotDescription,
)

_JOINT_TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide", "ball": "ball"}


class ConnectedPoints(NamedTuple):
    """Two points (3,) that a loop keeps together, each in the frame of its link."""

    name: str
    links: tuple[str, str]
    points_m: tuple[FloatArray, FloatArray]


def write_mjcf(
    description: RobotDescription,
    connected: Sequence[ConnectedPoints] = (),
    excluded: Sequence[tuple[str, str]] = (),
) -> WrittenDescription:
    """The description as an MJCF file. Mesh files are named by their uri, or relative to the root if that is a URL.

    The tree of joints says nothing of loops; `connected` closes them. `excluded` are links that never collide, by name.

    Speed limits and PyBullet's contact numbers are losses. Raises InvalidInput `robot/not-expressible` for planar
    joints, floating joints inside a tree, and shapes without a kind.
    """
    return _Writing(description).written(connected, excluded)


class _Writing:
    """One document: assets are collected while bodies are xml."""

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self.lost: list[Diagnostic] = []
        self.meshes: dict[str, Element] = {}
        self.materials: dict[str, Element] = {}
        self.textures: dict[str, Element] = {}

    def written(self, connected: Sequence[ConnectedPoints], excluded: Sequence[tuple[str, str]]) -> WrittenDescription:
        world = element("worldbody")
        bodies = {WORLD_LINK: world}
        carriers = joints_of(self.description.joints)
        by_name = {link.name: link for link in self.description.links}
        for name in breadth_first(self.description):
            link, joints = by_name[name], carriers.get(name, [])
            parent = bodies[joints[0].parent] if joints else world
            body = world if name == WORLD_LINK and not joints else self._body(link, joints)
            bodies[name] = body
            if body is not world:
                parent.children.append(body)
            body.children += [part for shape in link.shapes for part in self._geoms(shape)]
            body.children += [_camera(c.name, c.X_LC, c.fovy_rad) for c in link.cameras if c.fixed]
        assets = (*self.textures.values(), *self.materials.values(), *self.meshes.values())
        joints_by_name = {joint.name: joint for joint in self.description.joints}
        pairs = [(j, j.mimic) for j in self.description.joints if j.mimic is not None]
        equalities = [_equality(joint, mimic, joints_by_name[mimic.joint]) for joint, mimic in pairs]
        for pair in connected:
            names = [f"{pair.name}_{link}" for link in pair.links]
            for link, name, point in zip(pair.links, names, pair.points_m, strict=True):
                bodies[link].children.append(element("site", name=name, pos=numbers_text(point)))
            equalities.append(element("connect", name=pair.name, site1=names[0], site2=names[1]))
        top = element(
            "mujoco",
            element("compiler", angle="radian", autolimits="true"),
            element("asset", *assets) if assets else None,
            world,
            element("contact", *(element("exclude", body1=a, body2=b) for a, b in excluded)) if excluded else None,
            element("equality", *equalities) if equalities else None,
            model=self.description.name,
        )
        return WrittenDescription(to_bytes(top), (*self.lost, *unread_losses(self.description)))

    def _body(self, link: DescribedLink, joints: Sequence[DescribedJoint]) -> Element:
        body = element("body", name=link.name, **_placed(joints[0].X_PC if joints else np.eye(4)))
        if link.mocap:
            body.attributes["mocap"] = "true"
        if link.contact:
            self.lost.append(loss(f"<contact> of link '{link.name}' is not written", link.source))
        for joint in joints:
            if joint.kind != "fixed":
                body.children.append(self._joint(joint))
        if link.inertial is not None and link.inertia_source == "declared":
            body.children.append(_inertial(link.inertial))
        return body

    def _joint(self, joint: DescribedJoint) -> Element:
        if joint.velocity is not None:
            self.lost.append(loss(f"the speed limit of joint '{joint.name}' is not written", joint.source))
        if joint.kind == "floating" and joint.parent == WORLD_LINK:
            return element("freejoint", name=joint.name)
        if joint.kind not in _JOINT_TYPES:
            raise not_expressible(f"joint '{joint.name}' is {joint.kind} below '{joint.parent}'", joint.source)
        a = {"name": joint.name, "type": _JOINT_TYPES[joint.kind]}
        if joint.kind != "ball":
            a["axis"] = numbers_text(joint.axis_C)
        if joint.anchor_C.any():
            a["pos"] = numbers_text(joint.anchor_C)
        if joint.limits is not None and joint.kind != "continuous":
            a["range"] = numbers_text(joint.limits)
        if joint.effort is not None and joint.effort > 0.0:
            a["actuatorfrcrange"] = numbers_text((-joint.effort, joint.effort))
        numbers = {
            "ref": joint.reference,
            "springref": joint.spring_reference,
            "damping": joint.damping,
            "frictionloss": joint.friction,
            "armature": joint.armature,
            "stiffness": joint.stiffness,
        }
        return element("joint", **a, **{key: number_text(value) for key, value in numbers.items() if value != 0.0})

    def _geoms(self, shape: DescribedShape) -> list[Element]:
        """The shape as a geom."""
        a = {"name": shape.name} if shape.name else {}
        a |= _kind_and_size(shape) | _placed(shape.X_LS)
        if shape.mesh is not None:
            a["mesh"] = self._mesh(shape.mesh, shell=not shape.collides)
        if not shape.collides:
            a |= {"contype": "0", "conaffinity": "0"}
        if shape.group:
            a["group"] = str(shape.group)
        if shape.friction is not None:
            a["friction"] = number_text(shape.friction.dynamic)
        if shape.mass_kg is not None or shape.density_kgm3 is None:
            a["mass"] = number_text(shape.mass_kg) if shape.mass_kg else "0"
        else:
            a["density"] = number_text(shape.density_kgm3)
        if shape.material is not None:
            a |= self._material(shape.material)
        return [element("geom", **a)]

    def _material(self, material: DescribedMaterial) -> dict[str, str]:
        """Attributes of a geom; a named material becomes an asset."""
        rgba = {"rgba": numbers_text(material.rgba)} if material.rgba is not None else {}
        if not material.name:
            return rgba
        xml = element("material", name=material.name, **rgba)
        for key in ("metallic", "roughness", "specular", "shininess", "emission"):
            value = getattr(material, key)
            if value is not None:
                xml.attributes[key] = number_text(value)
        if material.texture:
            self.textures[material.name] = element("texture", name=material.name, type="2d", file=material.texture)
            xml.attributes["texture"] = material.name
        stated = self.materials.setdefault(material.name, xml)
        return {"material": material.name} | (rgba if stated.attributes != xml.attributes else {})

    def _mesh(self, mesh: MeshReference, *, shell: bool) -> str:
        """The name of the mesh asset."""
        a: dict[str, str] = {"inertia": "shell"} if shell else {}
        if mesh.uri:
            a["file"] = mesh.path if "://" in mesh.uri and mesh.path else mesh.uri
        if mesh.vertices is not None:
            a["vertex"] = numbers_text(mesh.vertices.ravel())
        if mesh.triangles is not None:
            a["face"] = " ".join(str(int(k)) for k in mesh.triangles.ravel())
        if mesh.scale != (1.0, 1.0, 1.0):
            a["scale"] = numbers_text(mesh.scale)
        if any(mesh.reference_position_m):
            a["refpos"] = numbers_text(mesh.reference_position_m)
        if any(mesh.reference_quat_wxyz[1:]):
            a["refquat"] = numbers_text(mesh.reference_quat_wxyz)
        for name in (mesh.name, *(f"mesh_{k}" for k in range(len(self.meshes) + 1))):
            other = self.meshes.get(name)
            if name and (other is None or other.attributes == {"name": name, **a}):
                self.meshes[name] = element("mesh", name=name, **a)
                return name
        raise AssertionError("one of these names is free")


def _kind_and_size(shape: DescribedShape) -> dict[str, str]:
    """MuJoCo's type and half lengths."""
    if shape.problem is not None or shape.kind in ("heightfield", "fitted", "unknown"):
        raise not_expressible(f"a shape of kind '{shape.kind}' is not written", shape.source)
    if shape.kind == "mesh":
        return {"type": "mesh"}
    if shape.kind in ("cylinder", "capsule"):
        return {"type": shape.kind, "size": numbers_text((shape.size_m[0], shape.size_m[1] / 2.0))}
    if shape.kind == "plane":
        return {"type": "plane", "size": numbers_text((shape.size_m[0] / 2.0, shape.size_m[1] / 2.0, 1.0))}
    half = shape.size_m if shape.kind in ("sphere", "ellipsoid") else tuple(s / 2.0 for s in shape.size_m)
    return {"type": shape.kind, "size": numbers_text(half)}


def _placed(X: FloatArray) -> dict[str, str]:
    """`pos` and `quat` of a pose; none where they are the identity."""
    a = {"pos": numbers_text(X[:3, 3])} if X[:3, 3].any() else {}
    return a | ({} if np.array_equal(X[:3, :3], np.eye(3)) else {"quat": numbers_text(quat_of(X[:3, :3]))})


def _inertial(inertial: Inertial) -> Element:
    pos = {"pos": numbers_text(inertial.X_LI[:3, 3])}
    a = {**pos, **_placed(inertial.X_LI), "mass": number_text(inertial.mass_kg)}
    tensor_I = inertial.inertia_kgm2
    if tensor_I is not None and np.array_equal(tensor_I, np.diag(tensor_I.diagonal())):
        a["diaginertia"] = numbers_text(tensor_I.diagonal())
    elif tensor_I is not None:  # MuJoCo takes a full tensor only in the axes of the body.
        R = inertial.X_LI[:3, :3]
        tensor_L = R @ tensor_I @ R.T
        a.pop("quat", None)
        entries = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        a["fullinertia"] = numbers_text(tensor_L[i, j] for i, j in entries)
    return element("inertial", **a)


def _camera(name: str, X_LC: FloatArray, fovy_rad: float) -> Element:
    return element("camera", name=name, **_placed(X_LC), fovy=number_text(np.degrees(fovy_rad)))


def _equality(joint: DescribedJoint, mimic: Mimic, leader: DescribedJoint) -> Element:
    """The joint equality of a mimic, about the references of both joints."""
    constant = mimic.offset - joint.reference + mimic.multiplier * leader.reference
    polycoef = numbers_text((constant, mimic.multiplier, 0.0, 0.0, 0.0))
    return element("joint", joint1=joint.name, joint2=leader.name, polycoef=polycoef)
