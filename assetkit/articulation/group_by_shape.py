"""Interaction groups of a joint by geometry: its type, its axis against up, the form and the place of the moved link.

Every rule gives a chance from 0 to 1 (judgements on furniture and appliances, checked on drawn mechanisms and on the
table by eye of `tests/data/joints`); a group without a rule that fits is excluded. Lengths in metres, asset frame.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from assetkit.articulation.joint_view import JointView
from geom.articulation.closed_position import ClosedPosition
from geom.articulation.moved_shape import box_around, level_heading
from geom.pose import apply
from schemas.arrays import FloatArray

UPRIGHT, LEVEL = math.cos(math.radians(20.0)), math.sin(math.radians(20.0))  # of |z| of a unit vector
# Joints in a row: a knob on a door makes two; three are a limb of a robot.
MOST_CHAIN = 2
CARRIED_SHARE = 0.6  # links on the moved one beyond this share of its size: it is no end of a mechanism
ON_MOVED = 0.85  # factor for a joint of a link that another joint moves
LEAF_SHARE = 0.35  # thickness of a leaf, of its shorter side
EDGE = 0.2  # the axis of a leaf or arm lies in the outer fifth of its width
SELF_TURNING = 0.25  # offset of what turns about its own middle
# Longest edge of a knob or button, of the diagonal of what stays; up to the second share it may still be a knob.
SMALL, HALF_SIZE = 0.25, 0.45
ROUND = 2.2  # longest by shortest side across the axis of a knob; a bar on a round foot has less
PLATFORM_HEIGHT, PLATFORM_WIDTH = 0.5, 0.4  # height of a platform of its width; its width of that of what stays
# Length of an arm by its breadth, where that is at most so many times its thickness; and of a flat strip.
ARM, BAR, FLAT_STRIP = 2.2, 4.0, 6.0
ARM_TURN = math.radians(200.0)
# Shares of a drawer within the outline of the body: what comes out until it is open; across its way; along it if shut.
OUT_SHARE, WITHIN_ACROSS, WITHIN_ALONG = 0.15, 0.6, 0.5
ROD = 0.15  # what is thinner across its way than this share of its length is a rod, no drawer
COVER_SHARE = 0.1  # of the footprint of what stays: a lid covers more, a pedal less
GROUND = 0.02  # of the height of the object: a wheel touches the ground
# Two thin halves of like size: the smaller by the larger of their two longer edges, and of their thicknesses.
LIKE, LIKE_THICKNESS = 0.6, 0.35
HALF_SHARE = 0.2  # thickness of a half, of its shorter side
ALONG_LEAF = 0.3  # |z| of the normal of an upright leaf


@dataclass(frozen=True)
class ShapeReading:
    """Chances of groups by geometry with the observation in words; empty where nothing fits. `reason` is why."""

    chances: Mapping[str, float]
    reason: str


def read_shape(view: JointView, shut: ClosedPosition | None) -> ShapeReading:
    """The groups that fit the geometry of a joint; `shut` is where the object takes least room."""
    if view.in_loop:
        return ShapeReading({}, "part of a kinematic loop")
    if view.chain > MOST_CHAIN:
        return ShapeReading({}, f"one of {view.chain} joints in a row")
    if view.carried > CARRIED_SHARE:
        return ShapeReading({}, "the moved link carries others of like size")
    chances, reason = _turning(view, shut) if view.joint.is_angular else _sliding(view, shut)
    factor = ON_MOVED if view.depth else 1.0
    return ShapeReading({group: round(factor * chance, 3) for group, chance in chances.items()}, reason)


def _sliding(view: JointView, shut: ClosedPosition | None) -> tuple[dict[str, float], str]:
    moved, up = view.moved, abs(float(view.joint.axis[2]))
    press = pressed_position(view)
    if press is not None:
        at_rest_out = abs(view.joint.rest - press) > 0.5 * view.span
        chance = 0.65 if _is_small(view) else 0.45
        return ({"button": chance}, "small head that goes into the body") if at_rest_out else ({}, "starts inside")
    thickness = moved.core_thin_m / max(min(moved.width_m, moved.length_m), 1e-9)
    is_leaf = thickness <= LEAF_SHARE and abs(float(moved.thin[2])) <= ALONG_LEAF
    comes_out = (
        shut is not None
        and not shut.both_ways
        and _share_within(view, shut.closed) - _share_within(view, shut.open) >= OUT_SHARE
    )
    if is_leaf and not comes_out:
        return {"sliding_door": 0.55}, "upright leaf that slides along its own plane"
    if up > LEVEL:
        return {}, "slides up and down or obliquely"
    if not comes_out or shut is None:
        return {}, "slides, but does not come out of the body"
    if moved.width_m < ROD * moved.length_m:
        return {}, "a rod that slides out"
    within = _cross_share(view)
    if within < WITHIN_ACROSS or _share_within(view, shut.closed) < WITHIN_ALONG:
        return {}, "slides, but not out of the body"
    return {"drawer": 0.65, **({"sliding_door": 0.15} if is_leaf else {})}, "box that slides straight out of the body"


def pressed_position(view: JointView) -> float | None:
    """The end of the range at which a small sliding head is farthest inside; None for what is no such head."""
    moved, joint = view.moved, view.joint
    size = float(np.linalg.norm(np.ptp(view.fixed, axis=0)))
    if max(moved.extents_m) > HALF_SIZE * size or view.span > 1.2 * max(moved.extents_m) or view.span > 0.1 * size:
        return None
    middle = moved.anchor + 0.5 * sum(moved.along_m) * joint.axis
    middle = middle + 0.5 * sum(moved.wide_m) * moved.wide + 0.5 * sum(moved.thin_m) * moved.thin
    local = view.fixed - middle
    along = local @ joint.axis
    across = np.linalg.norm(local - along[:, None] * joint.axis, axis=1)
    near = across <= moved.diagonal_m
    if not near.any():
        return None
    side = float(along[near].mean())
    if abs(side) < 0.25 * moved.length_m:
        return None
    return view.limits[1] if side > 0.0 else view.limits[0]


def _turning(view: JointView, shut: ClosedPosition | None) -> tuple[dict[str, float], str]:
    moved, up = view.moved, abs(float(view.joint.axis[2]))
    if moved.offset <= SELF_TURNING:
        return _about_itself(view, up)
    if _is_wheel(view):
        return {}, "touches the ground"
    thin = moved.core_thin_m / max(min(moved.width_m, moved.length_m), 1e-9)
    at_edge = moved.edge <= EDGE
    halves = _half_chance(view, at_edge)
    if at_edge and thin <= LEAF_SHARE and not _is_arm(view):
        if halves:
            return {"folding": halves, "hinged_lid": 0.3, "hinged_door": 0.2}, "half of like size as what stays"
        if up >= UPRIGHT:
            return {"hinged_door": 0.65}, "upright leaf that turns about an upright edge"
        if up <= LEVEL:
            return _level_leaf(view, shut)
        return {}, "leaf that turns about an oblique edge"
    if halves:
        return {"folding": halves}, "half of like size as what stays"
    if at_edge and _is_arm(view) and not view.is_endless and view.span <= ARM_TURN:
        return {"lever": 0.6}, "arm that turns about one end between two stops"
    return {}, "turns, but neither about an edge nor about itself"


def _about_itself(view: JointView, up: float) -> tuple[dict[str, float], str]:
    moved = view.moved
    size = float(np.linalg.norm(np.ptp(view.fixed, axis=0)))
    breadth = max(float(np.ptp(view.fixed @ d)) for d in (moved.wide, moved.thin))
    if _is_wheel(view):
        return {}, "a wheel on the ground"
    roundness = moved.width_m / max(moved.thickness_m, 1e-9)
    is_platform = up >= UPRIGHT and moved.length_m <= PLATFORM_HEIGHT * moved.width_m
    if is_platform and roundness <= ROUND and moved.width_m >= PLATFORM_WIDTH * breadth:
        return {"turntable": 0.65 if view.is_endless else 0.5}, "platform that turns about its upright axis"
    if _half_chance(view, at_edge=False):
        return {"folding": 0.4}, "crossing halves of like size"
    if max(moved.extents_m) <= HALF_SIZE * size and roundness <= ROUND:
        return {"knob": 0.6 if _is_small(view) else 0.4}, "small thing that turns about its own axis"
    if max(moved.extents_m) <= HALF_SIZE * size and not view.is_endless and view.span <= math.radians(60.0):
        return {"lever": 0.4}, "small rocker between two stops"
    return {}, "turns about its own axis, but is no knob or platform"


def _level_leaf(view: JointView, shut: ClosedPosition | None) -> tuple[dict[str, float], str]:
    """A leaf about a level edge: it covers from above, or stands in front; then the edge is below or above."""
    moved = view.moved
    turn = view.motion(shut.closed if shut is not None else view.joint.rest)
    normal = turn[:3, :3] @ moved.thin
    if abs(float(normal[2])) > math.sin(math.radians(45.0)):
        points = apply(turn, moved.points)
        if _footprint(points) < COVER_SHARE * _footprint(view.fixed):
            return {"lever": 0.35, "hinged_lid": 0.2}, "small level leaf that turns about a level edge"
        on_top = float(points[:, 2].mean()) > float(np.quantile(view.fixed[:, 2], 0.5))
        return {"hinged_lid": 0.65 if on_top else 0.4}, "level leaf that turns about a level edge"
    points = apply(turn, moved.points)
    below = float(moved.anchor[2]) < float(points[:, 2].mean())
    if below:
        return {"hinged_door": 0.55, "hinged_lid": 0.25}, "upright leaf that turns down about its lower edge"
    return {"hinged_lid": 0.5, "hinged_door": 0.35}, "upright leaf that turns up about its upper edge"


def _is_small(view: JointView) -> bool:
    """Whether the moved link is small beside what stays."""
    return max(view.moved.extents_m) <= SMALL * float(np.linalg.norm(np.ptp(view.fixed, axis=0)))


def _is_arm(view: JointView) -> bool:
    """Whether the moved link is long across the axis and slim in both other directions, like a bar, not a board."""
    thin, other = sorted((view.moved.length_m, view.moved.thickness_m))
    ratio = view.moved.width_m / max(other, 1e-9)
    return ratio >= FLAT_STRIP or (ratio >= ARM and other <= BAR * thin)


def _is_wheel(view: JointView) -> bool:
    """Whether what turns about a level axis reaches the ground on which the object stands."""
    moved = view.moved
    if abs(float(view.joint.axis[2])) > LEVEL:
        return False
    low = min(float(view.fixed[:, 2].min()), float(moved.points[:, 2].min()))
    high = max(float(view.fixed[:, 2].max()), float(moved.points[:, 2].max()))
    about_middle = moved.offset <= SELF_TURNING and moved.width_m <= 1.3 * moved.thickness_m
    return about_middle and float(moved.points[:, 2].min()) <= low + GROUND * (high - low)


def _half_chance(view: JointView, at_edge: bool) -> float:
    """The chance that the moved link and its parent are two halves of like form, side by side at the axis."""
    moved = view.moved
    ours = np.sort([moved.length_m, moved.width_m, moved.core_thin_m])
    theirs = np.sort(_own_box(view.parent))
    ratios = np.minimum(ours, theirs) / np.maximum(np.maximum(ours, theirs), 1e-9)
    if (ratios < [LIKE_THICKNESS, LIKE, LIKE]).any() or max(ours[0] / ours[1], theirs[0] / theirs[1]) > HALF_SHARE:
        return 0.0
    local = view.parent - moved.anchor
    across = local - (local @ moved.axis)[:, None] * moved.axis
    middle = across.mean(axis=0)
    reach = float(np.linalg.norm(across, axis=1).max())
    parent_offset = float(np.linalg.norm(middle)) / max(reach, 1e-9)
    if at_edge:
        inside = _share_in_box(moved.points, view.parent)
        return 0.6 if parent_offset > SELF_TURNING and inside < 0.5 else 0.0
    return 0.4 if parent_offset <= SELF_TURNING and moved.width_m > ARM * moved.thickness_m else 0.0


def _footprint(points: FloatArray) -> float:
    """Area of the upright box around points (n, 3), seen from above."""
    return float(np.prod(box_around(points, level_heading(points))[:2]))


def _own_box(points: FloatArray) -> FloatArray:
    """Extents (3,) of points (n, 3) along their principal axes."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    return np.ptp(centred @ axes, axis=0)


def _share_in_box(points: FloatArray, of: FloatArray) -> float:
    """Share of points (n, 3) in the box around `of` (m, 3) along its principal axes."""
    middle = of.mean(axis=0)
    axes = np.linalg.eigh((of - middle).T @ (of - middle))[1]
    low, high = ((of - middle) @ axes).min(axis=0), ((of - middle) @ axes).max(axis=0)
    local = (points - middle) @ axes
    return float(((local >= low) & (local <= high)).all(axis=1).mean())


def _share_within(view: JointView, position: float) -> float:
    """Share of the moved link's length along its way that lies within the extent of what stays."""
    along = view.fixed @ view.joint.axis
    shift = position - view.joint.rest
    start = float(view.moved.anchor @ view.joint.axis) + shift
    low, high = start + view.moved.along_m[0], start + view.moved.along_m[1]
    common = min(high, float(along.max())) - max(low, float(along.min()))
    return max(common, 0.0) / max(high - low, 1e-9)


def _cross_share(view: JointView) -> float:
    """Share of the moved link's rectangle across its way that lies within that of what stays."""
    share = 1.0
    for direction, (low, high) in ((view.moved.wide, view.moved.wide_m), (view.moved.thin, view.moved.thin_m)):
        ours = (low, high)
        theirs = (view.fixed - view.moved.anchor) @ direction
        common = min(ours[1], float(theirs.max())) - max(ours[0], float(theirs.min()))
        share *= max(common, 0.0) / max(ours[1] - ours[0], 1e-9)
    return share
