"""Writes the twins of a package: a URDF of every object, and an MJCF of an articulated one, from the re-read USD.

URDF is a tree: a joint that closes a loop is left out, and the diagnostics say which. In MJCF it becomes `connect`
equalities: two points on the axis of a hinge, one of a ball joint; a slide has no such form and is left out as well.
Positions of joints are those of the source, so their zero need not be the rest state.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import formats
from assetkit.package.write_urdf import described_link, write_urdf
from formats.mjcf.write import ConnectedPoints
from geom.mechanism_pose import joint_motion
from geom.pose import pose
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.package import PackageContent
from schemas.robot_description import (
    DescribedJoint,
    DescribedLink,
    DescribedShape,
    JointLimits,
    Mimic,
    RobotDescription,
    ShapeFriction,
)
from usdio.reread.body import RereadPackage
from usdio.write.materials.mesh_materials import materials_per_mesh

VISUAL_GROUP, COLLISION_GROUP = 2, 3  # of MuJoCo geoms: its viewer shows groups 0 to 2
# REP 103 and urdfdom ask for an effort and a speed of every limited joint; these are beyond any household mechanism.
UNSTATED_EFFORT, UNSTATED_SPEED = 1000.0, 100.0
# Distance of the two points on a closing hinge: far enough apart to hold its axis, near enough to be about the joint.
HINGE_POINTS_M = 0.05


def write_twins(content_on_disk: RereadPackage, content: PackageContent, folder: Path) -> tuple[Path, ...]:
    """Write `<folder>/export/<asset_id>.urdf`, and `.xml` (MJCF) of an articulated object; returns the files.

    Numbers are those of the package as re-read from disk, digit for digit; visible meshes are those of `content`.
    """
    mechanism = content_on_disk.mechanism
    if mechanism is None:
        return (write_urdf(content_on_disk.body, content, folder, content_on_disk.shape_contacts),)
    export = folder / "export"
    (export / "meshes").mkdir(parents=True, exist_ok=True)
    description = _description(content_on_disk, mechanism, content, export)
    urdf, mjcf = (export / f"{content.asset_id}.{suffix}" for suffix in ("urdf", "xml"))
    urdf.write_bytes(formats.write_urdf(with_required_limits(description)).data)
    closed = formats.write_mjcf(for_mujoco(description), connected_points(mechanism), content_on_disk.filtered_pairs)
    mjcf.write_bytes(closed.data)
    return urdf, mjcf


def _description(
    package: RereadPackage, mechanism: Mechanism, content: PackageContent, export: Path
) -> RobotDescription:
    origins = {link.name: link.origin for link in mechanism.links}
    meshes: dict[str, list[tuple]] = {}
    for mesh, material in zip(content.model.meshes_by_id.values(), materials_per_mesh(content.model), strict=True):
        placed = replace(mesh, points=mesh.points - origins[mesh.link])
        meshes.setdefault(mesh.link, []).append((placed, material))
    links, first = [], 0
    for body in package.links:
        contacts = package.shape_contacts[first : first + len(body.shapes)]
        first += len(body.shapes)
        links.append(described_link(body, meshes.get(body.name, []), contacts, export, f"{body.name}_"))
    joints = tuple(described_joint(joint, mechanism) for joint in mechanism.tree)
    return RobotDescription(content.asset_id, "urdf", tuple(links), joints, mechanism.root.name)


def described_joint(joint: MechanismJoint, mechanism: Mechanism) -> DescribedJoint:
    """The joint with its zero where the source has it: the child stands there, not at rest."""
    origins = {link.name: link.origin for link in mechanism.links}
    X_PC = pose(None, -origins[joint.parent]) @ joint_motion(joint, -joint.rest) @ pose(None, origins[joint.child])
    coupling = joint.coupling
    return DescribedJoint(
        joint.name,
        joint.kind,
        joint.parent,
        joint.child,
        X_PC,
        joint.axis,
        limits=None if joint.limits is None else JointLimits(*joint.limits),
        effort=joint.effort,
        velocity=joint.velocity,
        damping=joint.damping,
        friction=joint.friction,
        armature=joint.armature,
        stiffness=joint.stiffness,
        spring_reference=joint.spring_rest,
        mimic=None if coupling is None else Mimic(coupling.joint, coupling.multiplier, coupling.offset),
    )


def connected_points(mechanism: Mechanism) -> tuple[ConnectedPoints, ...]:
    """The points that closing joints keep together, in the frames of their links."""
    origins = {link.name: link.origin for link in mechanism.links}
    pairs: list[ConnectedPoints] = []
    for joint in mechanism.joints:
        if not joint.closes_loop or joint.kind == "prismatic":
            continue
        ends = (0.0,) if joint.kind == "ball" else (-0.5 * HINGE_POINTS_M, 0.5 * HINGE_POINTS_M)
        for number, along in enumerate(ends, 1):
            point = joint.anchor + along * joint.axis
            places = (point - origins[joint.parent], point - origins[joint.child])
            pairs.append(ConnectedPoints(f"{joint.name}_{number}", (joint.parent, joint.child), places))
    return tuple(pairs)


def with_required_limits(description: RobotDescription) -> RobotDescription:
    """The description with an effort and a speed where limits are stated: URDF readers refuse limits without them."""
    joints = (
        replace(joint, effort=joint.effort or UNSTATED_EFFORT, velocity=joint.velocity or UNSTATED_SPEED)
        if joint.limits is not None
        else joint
        for joint in description.joints
    )
    return replace(description, joints=tuple(joints))


def for_mujoco(description: RobotDescription) -> RobotDescription:
    """The description with its shapes in the groups that MuJoCo users expect, and the friction of links at their
    shapes, where MJCF has it."""
    links = (
        replace(link, shapes=tuple(_shape_for_mujoco(shape, link) for shape in link.shapes), contact={})
        for link in description.links
    )
    return replace(description, links=tuple(links))


def _shape_for_mujoco(shape: DescribedShape, link: DescribedLink) -> DescribedShape:
    if not shape.collides:
        return replace(shape, group=VISUAL_GROUP)
    dynamic = link.contact.get("lateral_friction")
    of_link = None if dynamic is None else ShapeFriction(dynamic, dynamic)
    return replace(shape, group=COLLISION_GROUP, friction=shape.friction or of_link)
