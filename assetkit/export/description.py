"""The robot description of a package as re-read from its USD, for MJCF and URDF, and what the two lack of its contacts.

Frames: links in their own frames, as `schemas.robot_description` has them. Numbers are those of the USD, digit for
digit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from assetkit.package.write_twins import described_joint
from assetkit.package.write_urdf import described_link
from geom.pose import pose
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.physics import Contact, RigidBody
from schemas.robot_description import (
    WORLD_LINK,
    DescribedJoint,
    DescribedLink,
    DescribedShape,
    RobotDescription,
    ShapeFriction,
)
from usdio.reread.body import RereadPackage

_DEFAULT_COMBINE = "average"  # of UsdPhysics materials, which packages leave as it is


def description_of(
    name: str, content: RereadPackage, surfaces: Mapping[str, Sequence[DescribedShape]], folder: Path
) -> RobotDescription:
    """The description of a package with the visible shapes `surfaces` by link; writes hulls to `folder`/meshes.

    Every collision shape has its static and dynamic friction.
    """
    links: list[DescribedLink] = []
    first = 0
    for body in content.bodies:
        contacts = content.shape_contacts[first : first + len(body.shapes)]
        first += len(body.shapes)
        links.append(_link(body, contacts, tuple(surfaces.get(body.name, ())), folder, alone=not content.links))
    mechanism = content.mechanism
    joints = () if mechanism is None else tuple(described_joint(joint, mechanism) for joint in mechanism.tree)
    return RobotDescription(
        name, "urdf", tuple(links), joints, links[0].name if mechanism is None else mechanism.root.name
    )


def _link(
    body: RigidBody, contacts: Sequence[Contact], visible: tuple[DescribedShape, ...], folder: Path, *, alone: bool
) -> DescribedLink:
    prefix = "" if alone else f"{body.name}_"
    link = described_link(body, [], contacts, folder, prefix)
    colliders = tuple(
        replace(shape, friction=ShapeFriction(contact.static_friction, contact.dynamic_friction))
        for shape, contact in zip(link.shapes, contacts, strict=True)
    )
    return replace(link, shapes=(*visible, *colliders))


def free_in_the_world(description: RobotDescription) -> RobotDescription:
    """The description with a free joint between the world and its root; MuJoCo welds a root without one."""
    joint = DescribedJoint(f"{description.root}_free", "floating", WORLD_LINK, description.root, pose(None))
    links = (DescribedLink(WORLD_LINK), *description.links)
    return replace(description, links=links, joints=(joint, *description.joints), root=WORLD_LINK)


def contact_losses(content: RereadPackage, *, mjcf: bool) -> Iterator[Diagnostic]:
    """What the contacts of a package have that MJCF or URDF lacks, one finding for each kind of number.

    MuJoCo has one sliding friction per geom and no restitution, and takes the larger friction of two geoms. A link of
    a URDF has one restitution (PyBullet's); Drake's friction per shape has both coefficients.
    """
    contacts = content.shape_contacts
    if mjcf:
        differing = [c for c in contacts if c.static_friction != c.dynamic_friction]
        if differing:
            headline = "MJCF has one sliding friction: the dynamic one is written, the static one is not"
            yield _loss(headline, max(c.static_friction for c in differing))
        if bouncing := [c.restitution for c in contacts if c.restitution != 0.0]:
            yield _loss("MJCF has no restitution: it is not written", max(bouncing))
    elif any(len({c.restitution for c in of_body}) > 1 for of_body in _by_body(content)):
        yield _loss("a link of a URDF has one restitution: that of its first shape is written", None)
    others = sorted({c.combine for c in contacts if c.combine != _DEFAULT_COMBINE})
    if others:
        yield _loss(f"how frictions of two bodies combine ({', '.join(others)}) is not written", None)


def _by_body(content: RereadPackage) -> Iterator[tuple[Contact, ...]]:
    first = 0
    for body in content.bodies:
        yield content.shape_contacts[first : first + len(body.shapes)]
        first += len(body.shapes)


def joint_losses(content: RereadPackage, *, mjcf: bool) -> Iterator[Diagnostic]:
    """Joints that close loops and pairs of links that do not collide, where the format has no place for them."""
    mechanism = content.mechanism
    if mechanism is None:
        return
    for joint in mechanism.joints:
        if joint.closes_loop and (not mjcf or joint.kind == "prismatic"):
            headline = f"joint '{joint.name}' closes a loop, which the format does not hold: it is not written"
            yield finding("asset/export-loss", headline, where=Location(prim=joint.name))
    if not mjcf and content.filtered_pairs:
        pairs = "; ".join(f"{a} and {b}" for a, b in content.filtered_pairs)
        yield _loss(f"URDF cannot exclude pairs of links from collision: {pairs}", len(content.filtered_pairs))
    if not mjcf and mechanism.fixed_base:
        yield _loss("URDF does not hold the root in the world: the reader of the file decides (useFixedBase)", None)


def _loss(headline: str, value: float | None) -> Diagnostic:
    return finding("asset/export-loss", headline, value=value)
