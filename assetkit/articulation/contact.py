"""Where a hand moves a joint: a handle, knob or button by names or by shape, else the edge farthest from the axis.

From the surfaces and names of the moved link into position, normal and pull direction, at rest in the asset frame (m).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.articulation.interaction_group import task_of
from assetkit.articulation.joint_view import JointView
from assetkit.taxonomy.words import singulars, words_of
from geom.articulation.protruding_grip import find_standing_grip
from geom.mesh.surface_distance import NearestOnSurface
from schemas.arrays import FloatArray
from schemas.articulation import ContactKind, JointContact
from schemas.evidence import Evidence, inferred, measured
from schemas.model import Mesh
from schemas.parts import Part
from schemas.physics import Solid

CONTACT_DIGITS = 7  # of lengths in metres
GRIP_WORDS: dict[str, ContactKind] = {
    "handle": "handle",
    "grip": "handle",
    "pull": "handle",
    "knob": "knob",
    "button": "button",
}
# Judgements: a labelled part, at most; a mesh of that name; what stands out; the edge of a link of a known group, and
# of an unknown one.
BY_PART, BY_MESH_NAME, BY_STANDING_OUT, BY_EDGE, BY_EDGE_UNKNOWN = 0.85, 0.75, 0.6, 0.5, 0.3
OUTER = 0.1  # of the width of a leaf: its edge; of the depth of a drawer: its front
ARM_END = 0.25  # of an arm: what is pushed
MOST_OF_LINK = 0.6  # a grip is at most this share of the diagonal of its link ...
BAR_OF_LINK = 1.02  # ... a bar that spans the link may be as long, but not as wide


@dataclass(frozen=True)
class MovedLink:
    """What is known of the moved link: its solid, its visible meshes, and the parts on it."""

    name: str
    solid: Solid
    meshes: tuple[Mesh, ...]
    parts: tuple[Evidence[Part], ...]


@dataclass(frozen=True)
class _Region:
    kind: ContactKind
    points: FloatArray
    part: str | None
    confidence: float
    method: str


def find_contact(view: JointView, link: MovedLink, group: str, sense: int) -> Evidence[JointContact]:
    """The contact of a joint; `sense` is the sign of its motion towards open, `group` may be unknown."""
    task = task_of(group, angular=view.joint.is_angular)
    outward = _outward(view, group, sense)
    region = _named(link, view) if group not in ("knob", "button", "lever", "turntable") else None
    if region is None and task == "open" and group != "unknown":
        region = _by_shape(view, link, outward)
    if region is not None:
        position, normal = _outer_middle(region.points, outward), outward
    else:
        region = _edge(view, link, group, outward)
        position, normal = _edge_middle(view, region, group, outward)
        position = _on_solid(link.solid, position)
    pull = _pull(view, position, sense)
    if view.joint.is_angular and group in ("lever", "unknown"):
        normal = -pull  # the side that is pushed
    contact = JointContact(
        kind=region.kind,
        link=link.name,
        part=region.part,
        position_m=_point(position),
        normal=_point(normal),
        low_m=_point(region.points.min(axis=0)),
        high_m=_point(region.points.max(axis=0)),
        pull=_point(pull),
    )
    if region.method.startswith("name"):
        return inferred(contact, region.method, region.confidence)
    return measured(contact, region.method, confidence=region.confidence)


def _outward(view: JointView, group: str, sense: int) -> FloatArray:
    """(3,) the direction out of the face that a hand faces: the first motion of a leaf or drawer, against a press."""
    joint, moved = view.joint, view.moved
    if not joint.is_angular:
        return -sense * joint.axis if group == "button" else sense * joint.axis
    middle = moved.points.mean(axis=0)
    if group in ("knob", "turntable"):
        away = float((middle - view.fixed.mean(axis=0)) @ joint.axis)
        return joint.axis if away >= 0.0 else -joint.axis
    velocity = sense * _velocity(view, middle)
    side = float(velocity @ moved.thin)
    return moved.thin if side >= 0.0 else -moved.thin


def _pull(view: JointView, position: FloatArray, sense: int) -> FloatArray:
    """(3,) unit direction of the first motion of a point; the axis for a point on it."""
    velocity = sense * _velocity(view, position)
    speed = float(np.linalg.norm(velocity))
    return velocity / speed if speed > 0.0 else sense * view.joint.axis


def _velocity(view: JointView, point: FloatArray) -> FloatArray:
    """(3,) motion of a point of the moved link per unit of the joint's position, at rest."""
    joint = view.joint
    return np.cross(joint.axis, point - joint.anchor) if joint.is_angular else joint.axis


def _named(link: MovedLink, view: JointView) -> _Region | None:
    """The handle, knob or button of the moved link by labels of parts and names of its meshes."""
    for part in link.parts:
        label = part.value.label
        if label.value in GRIP_WORDS and label.confidence > 0.0:
            points = _points_of(part.value, link.meshes)
            if points is not None and _is_grip_size(points, view):
                confidence = round(min(BY_PART, label.confidence), 3)
                return _Region(GRIP_WORDS[label.value], points, part.value.part_id, confidence, "name of a part")
    named = [(mesh, word) for mesh in link.meshes if (word := _grip_word(mesh)) is not None]
    if not named or len(named) == len(link.meshes):
        return None
    groups: dict[str, list[Mesh]] = {}
    for mesh, word in named:
        groups.setdefault(word, []).append(mesh)
    for word, meshes in sorted(groups.items()):
        points = np.concatenate([m.points[np.unique(m.triangles)] for m in meshes])
        if _is_grip_size(points, view):
            return _Region(GRIP_WORDS[word], points, None, BY_MESH_NAME, f"name of a mesh: {word}")
    return None


def _grip_word(mesh: Mesh) -> str | None:
    """The word for a grip in the name of a mesh, of its source link or of its shape; None without one."""
    for name in (mesh.name, *mesh.source_path.split("/")[1:]):
        words = words_of(name)
        for word in GRIP_WORDS:
            if any(word in (w, *singulars(w)) for w in words):
                return word
    return None


def _is_grip_size(points: FloatArray, view: JointView) -> bool:
    """Whether points are a small part of the moved link, or a bar that spans it."""
    sides = np.sort(np.ptp(points, axis=0))
    whole = view.moved.diagonal_m
    small = float(np.linalg.norm(sides)) <= MOST_OF_LINK * whole
    return small or (float(sides[2]) <= BAR_OF_LINK * whole and float(sides[1]) <= 0.25 * float(sides[2]))


def _points_of(part: Part, meshes: Sequence[Mesh]) -> FloatArray | None:
    """Corners (n, 3) of the triangles of a part."""
    of_meshes = [m.points[np.unique(m.triangles[part.mask(m.id, len(m.triangles))])] for m in meshes]
    points = [p for p in of_meshes if len(p)]
    return np.concatenate(points) if points else None


def _by_shape(view: JointView, link: MovedLink, outward: FloatArray) -> _Region | None:
    line = (view.joint.anchor, view.joint.axis) if view.joint.is_angular else None
    grip = find_standing_grip(link.solid, outward, line)
    if grip is None:
        return None
    return _Region("knob" if grip.is_knob else "handle", grip.points, None, BY_STANDING_OUT, "stands out of the face")


def _edge(view: JointView, link: MovedLink, group: str, outward: FloatArray) -> _Region:
    """The region of the moved link that a hand reaches best where there is no grip."""
    points, moved = view.moved.points, view.moved
    sure = BY_EDGE_UNKNOWN if group == "unknown" else BY_EDGE
    if group in ("knob", "turntable", "button"):
        kind: ContactKind = "edge" if group == "turntable" else "button" if group == "button" else "knob"
        corners = link.solid.points[np.unique(link.solid.triangles)]
        part = next((p.value.part_id for p in link.parts if p.value.label.value == group), None)
        return _Region(kind, corners, part, sure if group == "turntable" else BY_STANDING_OUT, "the moved link itself")
    if not view.joint.is_angular:
        along = points @ outward
        front = points[along >= along.max() - OUTER * float(np.ptp(along))]
        return _Region("edge", front, None, sure, "front of the moved link")
    wide = (points - moved.anchor) @ moved.wide
    far = wide if abs(moved.wide_m[1]) >= abs(moved.wide_m[0]) else -wide
    share = ARM_END if group == "lever" else OUTER
    edge = points[far >= far.max() - share * moved.width_m]
    return _Region("edge", edge, None, sure, "the edge farthest from the axis")


def _edge_middle(view: JointView, region: _Region, group: str, outward: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Position and normal (3,) on a region without a grip; of what turns about itself on its rim."""
    if group in ("knob", "turntable"):
        local = region.points - view.joint.anchor
        along = local @ view.joint.axis
        across = local - along[:, None] * view.joint.axis
        radius = np.linalg.norm(across, axis=1)
        outer = along * float(outward @ view.joint.axis)
        upper = np.flatnonzero(outer >= np.median(outer))
        rim = upper[int(np.round(radius[upper], CONTACT_DIGITS).argmax())]
        return region.points[rim], across[rim] / max(float(radius[rim]), 1e-12)
    return _outer_middle(region.points, outward), outward


def _on_solid(solid: Solid, position: FloatArray) -> FloatArray:
    """(3,) a position in the solid as it is, one beside it (over a hollow edge) moved to the nearest point of it."""
    nearest = NearestOnSurface(solid.points, solid.triangles)
    if solid.kind != "shell" and nearest.inside(position[None])[0]:
        return position
    return nearest(position[None])[0][0]


def _outer_middle(points: FloatArray, outward: FloatArray) -> FloatArray:
    """(3,) middle of the box around the outer half of points (n, 3) along a direction."""
    along = points @ outward
    outer = points[along >= 0.5 * (along.min() + along.max())]
    return 0.5 * (outer.min(axis=0) + outer.max(axis=0))


def _point(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = (round(float(v), CONTACT_DIGITS) + 0.0 for v in values)
    return x, y, z
