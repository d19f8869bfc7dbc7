"""Plain mechanisms of each interaction group, built of boxes and cylinders, for properties of the uses of joints.

Every builder gives one joint between a body and a moved link, shut at position 0 and opening with growing positions,
front towards -y. `transformed` turns the whole about z, reverses the axis, shifts the zero and renames everything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Manifold

from assetkit.stage import LinkSurface
from geom.pose import rotation_about
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint, MechanismJointKind, MechanismLink
from schemas.physics import Solid

Box = tuple[Sequence[float], Sequence[float]]  # lowest and highest corner


@dataclass(frozen=True)
class DrawnMechanism:
    """A mechanism with the surfaces of its links; `group` is what it was built as."""

    group: str
    mechanism: Mechanism
    links: tuple[LinkSurface, ...]

    @property
    def joint(self) -> MechanismJoint:
        return self.mechanism.joints[0]


def box(low: Sequence[float], high: Sequence[float]) -> Manifold:
    low_m, high_m = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return Manifold.cube(high_m - low_m).translate(low_m)


def rod(start: Sequence[float], end: Sequence[float], radius: float) -> Manifold:
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    straight = Manifold.cylinder(length, radius, radius, 32)
    z = (b - a) / length
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return straight.transform(np.column_stack([x, np.cross(z, x), z, a]))


def solid_of(*parts: Manifold) -> Solid:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole + part
    mesh = whole.to_mesh64()
    return Solid(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32), "closed")


def built(
    group: str,
    body: Solid,
    moved: Solid,
    kind: MechanismJointKind,
    anchor: Sequence[float],
    axis: Sequence[float],
    limits: tuple[float, float] | None,
    names: tuple[str, str, str] = ("body", "moved", "joint"),
) -> DrawnMechanism:
    p = np.asarray(anchor, dtype=float)
    joint = MechanismJoint(names[2], kind, names[0], names[1], p, np.asarray(axis, dtype=float), 0.0, limits)
    links = (MechanismLink(names[0], np.zeros(3)), MechanismLink(names[1], p))
    return DrawnMechanism(
        group, Mechanism(links, (joint,)), (LinkSurface(names[0], body), LinkSurface(names[1], moved))
    )


def open_case(width: float, depth: float, height: float, board: float) -> Manifold:
    """A case of boards that is open towards -y, bottom centre of its box at the origin."""
    x, y = 0.5 * width, 0.5 * depth
    whole = box((-x, -y, 0.0), (x, y, height))
    return whole - box((-x + board, -y - 1.0, board), (x - board, y - board, height - board))


def tray(low: Sequence[float], high: Sequence[float], wall: float) -> Manifold:
    """A box that is open at the top."""
    inner = [a + wall for a in low], [high[0] - wall, high[1] - wall, high[2] + 1.0]
    return box(low, high) - box(*inner)


def drawer(width: float, depth: float, height: float, *, handle: bool, travel: float) -> DrawnMechanism:
    board = 0.03 * width
    x, y = 0.5 * width - 1.2 * board, 0.5 * depth
    parts = [tray((-x, -y, 1.2 * board), (x, y - 1.5 * board, height - 1.5 * board), 0.5 * board)]
    if handle:
        out, z = -y - 0.06 * depth, 0.5 * height
        parts.append(rod((-0.2 * width, out, z), (0.2 * width, out, z), 0.02 * width))
        parts += [
            rod((s * 0.15 * width, -y + board * 0.2, z), (s * 0.15 * width, out, z), 0.012 * width) for s in (-1, 1)
        ]
    return built(
        "drawer",
        solid_of(open_case(width, depth, height, board)),
        solid_of(*parts),
        "prismatic",
        (0.0, 0.0, 0.5 * height),
        (0.0, -1.0, 0.0),
        (0.0, travel * depth),
    )


def hinged_door(width: float, depth: float, height: float, *, handle: bool, turn: float, left: bool) -> DrawnMechanism:
    board = 0.03 * width
    x, y = 0.5 * width, 0.5 * depth
    thickness = 0.04 * width
    parts = [box((-x, -y - thickness, 0.0), (x, -y, height))]
    side = 1.0 if left else -1.0  # hinge at -x: the handle is at +x
    if handle:
        out = -y - thickness - 0.05 * width
        bar = 0.4 * height
        parts.append(rod((side * 0.4 * width, out, bar), (side * 0.4 * width, out, 1.5 * bar), 0.015 * width))
        parts += [
            rod((side * 0.4 * width, -y - 0.5 * thickness, z), (side * 0.4 * width, out, z), 0.01 * width)
            for z in (1.05 * bar, 1.45 * bar)
        ]
    return built(
        "hinged_door",
        solid_of(open_case(width, depth, height, board)),
        solid_of(*parts),
        "revolute",
        (-side * x, -y - 0.5 * thickness, 0.5 * height),
        (0.0, 0.0, -side),
        (0.0, turn),
    )


def hinged_lid(width: float, depth: float, height: float, *, turn: float) -> DrawnMechanism:
    board = 0.04 * width
    x, y = 0.5 * width, 0.5 * depth
    return built(
        "hinged_lid",
        solid_of(tray((-x, -y, 0.0), (x, y, height), board)),
        solid_of(box((-x, -y, height + 0.001), (x, y, height + 0.05 * width))),
        "revolute",
        (0.0, y, height + 0.001),
        (-1.0, 0.0, 0.0),
        (0.0, turn),
    )


def sliding_door(width: float, depth: float, height: float) -> DrawnMechanism:
    board = 0.03 * width
    x, y = 0.5 * width, 0.5 * depth
    return built(
        "sliding_door",
        solid_of(open_case(width, depth, height, board)),
        solid_of(box((-x, -y - 0.03 * width, 0.05 * height), (0.05 * width, -y - 0.005 * width, 0.95 * height))),
        "prismatic",
        (0.0, -y, 0.5 * height),
        (1.0, 0.0, 0.0),
        (0.0, 0.45 * width),
    )


def knob(size: float, radius: float, length: float, *, turn: float | None) -> DrawnMechanism:
    front = -0.5 * size
    r = radius * size
    grip = box((-0.25 * r, front - length * r, 0.5 * size - r), (0.25 * r, front - 0.2 * r, 0.5 * size + r))
    return built(
        "knob",
        solid_of(box((-0.5 * size, front, 0.0), (0.5 * size, -front, size))),
        solid_of(rod((0.0, front - 0.001, 0.5 * size), (0.0, front - 0.4 * r, 0.5 * size), r), grip),
        "continuous" if turn is None else "revolute",
        (0.0, front, 0.5 * size),
        (0.0, -1.0, 0.0),
        None if turn is None else (0.0, turn),
    )


def button(size: float, radius: float, travel: float) -> DrawnMechanism:
    """On the top of a box; position 0 is released, and growing positions press it down."""
    r = radius * size
    return built(
        "button",
        solid_of(box((-0.5 * size, -0.5 * size, 0.0), (0.5 * size, 0.5 * size, 0.4 * size))),
        solid_of(rod((0.0, 0.0, 0.4 * size - 0.2 * r), (0.0, 0.0, 0.4 * size + r), r)),
        "prismatic",
        (0.0, 0.0, 0.4 * size),
        (0.0, 0.0, -1.0),
        (0.0, travel * r),
    )


def lever(size: float, length: float, *, turn: float) -> DrawnMechanism:
    front = -0.15 * size
    arm = rod((0.0, front - 0.05 * size, 0.7 * size), (length * size, front - 0.05 * size, 0.7 * size), 0.04 * size)
    hub = rod((0.0, front, 0.7 * size), (0.0, front - 0.08 * size, 0.7 * size), 0.06 * size)
    return built(
        "lever",
        solid_of(box((-0.5 * size, front, 0.0), (0.5 * size, -front, size))),
        solid_of(arm, hub),
        "revolute",
        (0.0, front, 0.7 * size),
        (0.0, -1.0, 0.0),
        (0.0, turn),
    )


def turntable(size: float, plate: float) -> DrawnMechanism:
    return built(
        "turntable",
        solid_of(rod((0.0, 0.0, 0.0), (0.0, 0.0, 0.15 * size), 0.5 * size)),
        solid_of(rod((0.0, 0.0, 0.16 * size), (0.0, 0.0, 0.22 * size), plate * size)),
        "continuous",
        (0.0, 0.0, 0.16 * size),
        (0.0, 0.0, 1.0),
        None,
    )


def folding(width: float, depth: float, thickness: float) -> DrawnMechanism:
    """Two plates that lie on each other when shut, like a laptop."""
    x, y, t = 0.5 * width, 0.5 * depth, thickness * width
    return built(
        "folding",
        solid_of(box((-x, -y, 0.0), (x, y, t))),
        solid_of(box((-x, -y, 1.05 * t), (x, y, 2.0 * t))),
        "revolute",
        (0.0, y, 1.02 * t),
        (-1.0, 0.0, 0.0),
        (0.0, math.radians(120.0)),
    )


def transformed(
    drawn: DrawnMechanism, *, yaw: float, reverse: bool, zero: float, names: Sequence[str]
) -> DrawnMechanism:
    """The same object turned about z by `yaw`, with the axis reversed, positions counted from elsewhere, and other
    names of body, moved link and joint.
    """
    R = rotation_about((0.0, 0.0, 1.0), yaw)

    def turn(points: FloatArray) -> FloatArray:
        return points @ R.T

    sign = -1.0 if reverse else 1.0
    joint = drawn.joint
    limits = None if joint.limits is None else tuple(sorted(sign * q + zero for q in joint.limits))
    body, moved, name = names
    changed = replace(
        joint,
        name=name,
        parent=body,
        child=moved,
        anchor=turn(joint.anchor),
        axis=sign * turn(joint.axis),
        rest=sign * joint.rest + zero,
        limits=limits,
    )
    links = tuple(
        MechanismLink(n, turn(link.origin)) for n, link in zip((body, moved), drawn.mechanism.links, strict=True)
    )
    surfaces = tuple(
        LinkSurface(n, replace(s.solid, points=turn(s.solid.points)))
        for n, s in zip((body, moved), drawn.links, strict=True)
    )
    return DrawnMechanism(drawn.group, Mechanism(links, (changed,)), surfaces)
