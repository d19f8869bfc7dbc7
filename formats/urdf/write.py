"""Writes a `RobotDescription` as URDF, SI, every number so that it reads back as the same double.

`<contact>` and `<capsule>` are read by PyBullet, `drake:proximity_properties` by Drake; other tools ignore them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from formats.losses import WrittenDescription, loss, not_expressible, unread_losses
from formats.tree import joints_of
from formats.urdf.read import DRAKE_PREFIX, PROXIMITY
from formats.xml_elements import Element
from formats.xml_text import element, number_text, numbers_text, to_bytes
from geom.pose import rpy_of_rotation
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic
from schemas.robot_description import (
    DescribedJoint,
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    Inertial,
    MeshReference,
    RobotDescription,
    ShapeFriction,
)

DRAKE = "http://drake.mit.edu"  # the namespace that Drake's own files declare for their additions to URDF
_ZEROS = "0 0 0"


def write_urdf(description: RobotDescription) -> WrittenDescription:
    """The description as a URDF file. Numbers of a joint's dynamics that URDF lacks are losses, with a warning each.

    Raises InvalidInput `robot/not-expressible` for joints whose axis is not in the frame of their child, several
    joints of one child, shapes that URDF lacks, and masses that only follow from shapes.
    """
    for child, joints in joints_of(description.joints).items():
        if len(joints) > 1:
            raise not_expressible(f"link '{child}' is carried by {len(joints)} joints", joints[1].source)
    lost: list[Diagnostic] = []
    frictions = any(shape.friction for link in description.links for shape in link.shapes)
    attributes = {"xmlns:drake": DRAKE} if frictions else {}
    robot = element("robot", **attributes, name=description.name)
    robot.children += [_link(link) for link in description.links]
    robot.children += [_joint(joint, lost) for joint in description.joints]
    return WrittenDescription(to_bytes(robot), (*lost, *unread_losses(description)))


def contact_element(contact: Mapping[str, float]) -> Element:
    """PyBullet's `<contact>`."""
    return element("contact", *(element(name, value=number_text(value)) for name, value in contact.items()))


def inertial_element(inertial: Inertial) -> Element:
    """`<inertial>` with the full tensor."""
    tensor = inertial.inertia_kgm2
    entries: dict[str, str] = {}
    if tensor is not None:
        entries = {f"i{'xyz'[i]}{'xyz'[j]}": number_text(tensor[i, j]) for i in range(3) for j in range(i, 3)}
    mass = element("mass", value=number_text(inertial.mass_kg))
    return element(
        "inertial", _origin(inertial.X_LI, "", _ZEROS), mass, element("inertia", **entries) if entries else None
    )


def friction_element(friction: ShapeFriction) -> Element:
    """Drake's coefficients of one shape."""
    static, dynamic = number_text(friction.static), number_text(friction.dynamic)
    return element(
        PROXIMITY,
        element(f"{DRAKE_PREFIX}mu_static", value=static),
        element(f"{DRAKE_PREFIX}mu_dynamic", value=dynamic),
    )


def _link(link: DescribedLink) -> Element:
    if link.inertia_source == "shapes":
        raise not_expressible(f"the mass of link '{link.name}' follows from its shapes", link.source)
    inertial = inertial_element(link.inertial) if link.inertial is not None else None
    xml = element("link", contact_element(link.contact) if link.contact else None, inertial, name=link.name)
    for shape in link.shapes:
        xml.children += [_shape(shape, "visual")] if shape.drawn else []
        xml.children += [_shape(shape, "collision")] if shape.collides else []
    return xml


def _shape(shape: DescribedShape, tag: str) -> Element:
    xml = element(tag, **({"name": shape.name} if shape.name else {}))
    zeros = _ZEROS if tag == "visual" else ""
    xml.children = [_origin(shape.X_LS, zeros, zeros), element("geometry", _geometry(shape))]
    if shape.material is not None and tag == "visual":
        xml.children.append(_material(shape.material))
    if shape.friction is not None and tag == "collision":
        xml.children.append(friction_element(shape.friction))
    return xml


def _geometry(shape: DescribedShape) -> Element:
    if shape.kind == "mesh" and shape.mesh is not None and shape.mesh.uri and not _has_reference(shape.mesh):
        scale = "1 1 1" if shape.mesh.scale == (1.0, 1.0, 1.0) else numbers_text(shape.mesh.scale)
        return element("mesh", filename=shape.mesh.uri, scale=scale)
    if shape.problem is not None or shape.kind not in ("box", "sphere", "cylinder", "capsule"):
        raise not_expressible(f"a shape of kind '{shape.kind}' is not written", shape.source)
    if shape.kind == "box":
        return element("box", size=numbers_text(shape.size_m))
    if shape.kind == "sphere":
        return element("sphere", radius=number_text(shape.size_m[0]))
    return element(shape.kind, radius=number_text(shape.size_m[0]), length=number_text(shape.size_m[1]))


def _has_reference(mesh: MeshReference) -> bool:
    """Whether MuJoCo's refpos or refquat move the vertices."""
    return any(mesh.reference_position_m) or any(mesh.reference_quat_wxyz[1:])


def _material(material: DescribedMaterial) -> Element:
    color = element("color", rgba=numbers_text(material.rgba)) if material.rgba is not None else None
    texture = element("texture", filename=material.texture) if material.texture else None
    return element("material", color, texture, name=material.name)


def _joint(joint: DescribedJoint, lost: list[Diagnostic]) -> Element:
    if joint.anchor_C.any() or joint.reference != 0.0:
        headline = f"the axis of joint '{joint.name}' does not go through its child's origin, or its zero is elsewhere"
        raise not_expressible(headline, joint.source)
    unwritten = {"armature": joint.armature, "stiffness": joint.stiffness}
    lost += [
        loss(f"the {name} of joint '{joint.name}' is not written", joint.source)
        for name, value in unwritten.items()
        if value != 0.0
    ]
    xml = element(
        "joint",
        _origin(joint.X_PC, _ZEROS, _ZEROS),
        element("parent", link=joint.parent),
        element("child", link=joint.child),
        name=joint.name,
        type="spherical" if joint.kind == "ball" else joint.kind,
    )
    if joint.kind in ("revolute", "continuous", "prismatic", "planar"):
        xml.children.append(element("axis", xyz=numbers_text(joint.axis_C)))
    limit = _stated(effort=joint.effort, velocity=joint.velocity)
    if joint.limits is not None:
        limit = _stated(lower=joint.limits.lower, upper=joint.limits.upper) | limit
    dynamics = _stated(damping=joint.damping or None, friction=joint.friction or None)
    xml.children += [element("limit", **limit)] if limit else []
    xml.children += [element("dynamics", **dynamics)] if dynamics else []
    if joint.mimic is not None:
        numbers = {"multiplier": number_text(joint.mimic.multiplier), "offset": number_text(joint.mimic.offset)}
        xml.children.append(element("mimic", joint=joint.mimic.joint, **numbers))
    return xml


def _stated(**numbers: float | None) -> dict[str, str]:
    return {name: number_text(value) for name, value in numbers.items() if value is not None}


def _origin(X: FloatArray, no_shift: str, no_turn: str) -> Element:
    """`<origin>` of a pose; vectors of zeros are written as the texts given."""
    return element("origin", xyz=_vector(X[:3, 3], no_shift), rpy=_vector(rpy_of_rotation(X[:3, :3]), no_turn))


def _vector(values: Iterable[float], zeros: str) -> str:
    numbers = np.asarray(list(values), dtype=np.float64)
    return zeros if zeros and not numbers.any() else numbers_text(numbers.tolist())
