"""The levels of a stack: where each thing may be on the top of the one below it, and whether the stack always stands.

A level is a place on the lower thing, whose polygon holds the footprint of the upper one at every pose that the group
allows: an upper thing may reach beyond the top on which it stands, so that the footprint needs no room there. What
holds instead is balance. At every pose the contact of two things contains a disc about the middle of the top, and one
about the middle of the foot on it: the circles that fit into top and foot are shifted by no more than the alignment.
Whatever the masses are, a thing above passes its weight down through the contact when the middle of its footprint is
surely within one of the two discs. Metres, radians.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, cos, hypot, inf, pi, radians, sqrt

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Body
from schemas.arrays import FloatArray
from schemas.scene.geometry import Domain, ScenePlace, Stance
from schemas.scene.placing import StackGroup
from source.tree import Path

LEVEL = "stack"  # name of the place on the thing below
TURN_STEP_RAD = radians(2.0)  # between two headings of which the outlines are compared
SIDES, BOX_SHARE = 16, 1.1  # of the polygon around round things; a box may be larger by this factor
PAD_M = 1e-4  # by which a level is larger than what it holds: cells of plans are rounded to micrometres
CONTACT_M = 2e-4  # pieces of one level face differ by less
MIDDLE_INSIDE = (
    0.2  # share of the radius of a disc as large as the foot by which the middle of a thing stays in its support
)


@dataclass(frozen=True)
class StackTier:
    """The place of an upper thing on the lower one, and the poses that the group allows there."""

    place: ScenePlace
    domain: Domain


def stack_level(top: ScenePlace, upper: Body, group: StackGroup, path: Path) -> StackTier:
    """The level on `top`, a surface of the lower thing, for all candidates of a body."""
    low, high = (radians(angle) for angle in group.turn_deg)
    outlines = [prism.outline_m for prism in upper.resting_orientations[0].prisms]
    points = _swept(np.concatenate(outlines), low, high)
    area = _outer(points, group.alignment + PAD_M)
    span = (-group.alignment, group.alignment)
    yaw = (low, high) if high - low < 2.0 * pi else (-pi, pi)
    return StackTier(replace(top, name=LEVEL, polygon=area), Domain(span, span, yaw, (0,), (), (*path, "alignment")))


def most_off_balance_m(things: Sequence[tuple[Body, ScenePlace]], alignment_m: float) -> float:
    """By how much a load may leave its support at worst, over all poses; negative where the stack always stands.

    `things` are bodies and the tops on which the next one stands, the lowest first.
    """
    return max(
        (
            _off_level_m(things[k:], body, alignment_m)
            for k in range(len(things) - 1)
            for body in _bodies(things[k + 1][0])
        ),
        default=-inf,
    )


def _off_level_m(things: Sequence[tuple[Body, ScenePlace]], body: Body, alignment_m: float) -> float:
    """The same of the contact between the first two of `things`, of which the upper one is `body`."""
    (lower, top), shift = things[0], sqrt(2.0) * alignment_m
    stance = body.resting_orientations[0]
    foot, middle = _foot(stance), _middle(stance)
    on_top, on_foot = _top_radius_m(lower.resting_orientations[0], top), _inside_m(foot, foot.centroid)
    away = shift + _off(foot.centroid)  # of the middle of the foot from that of the top
    about_top, about_foot = min(on_top, on_foot - away), min(on_foot, on_top - away)
    margin = MIDDLE_INSIDE * sqrt(foot.area / pi)
    own = min(shift + _off(middle) - about_top, middle.distance(foot.centroid) - about_foot) + margin
    beyond, climb = [own], shift
    carrying = shapely.Point(*things[1][1].origin_P_m[:2])  # middle of the top of `body`, which carries all others
    for other, its_top in things[2:]:
        far = climb + max(_off(_middle(one.resting_orientations[0])) for one in _bodies(other))
        beyond.append(min(shift + _off(carrying) - about_top, carrying.distance(foot.centroid) - about_foot) + far)
        climb += hypot(float(its_top.origin_P_m[0]), float(its_top.origin_P_m[1])) + shift
    return max(beyond)


def _bodies(body: Body) -> Sequence[Body]:
    return body.candidates or (body,)


def _top_radius_m(lower: Stance, top: ScenePlace) -> float:
    """Radius of the disc about the middle of the top on which the lower thing carries."""
    height = float(top.origin_P_m[2]) + lower.origin_height_m
    pieces = [prism for prism in lower.prisms if abs(prism.high_m - height) <= CONTACT_M]
    area = shapely.union_all([shapely.Polygon(prism.outline_m) for prism in pieces])
    return _inside_m(area, shapely.Point(*top.origin_P_m[:2]))


def _inside_m(area: BaseGeometry, point: shapely.Point) -> float:
    """Radius of the largest disc about a point that lies in an area; 0 where the point does not."""
    return float(point.distance(area.boundary)) if area.covers(point) else 0.0


def _foot(stance: Stance) -> BaseGeometry:
    return shapely.union_all([shapely.Polygon(p.outline_m) for p in stance.prisms if p.low_m <= CONTACT_M])


def _middle(stance: Stance) -> shapely.Point:
    return shapely.union_all([shapely.Polygon(prism.outline_m) for prism in stance.prisms]).centroid


def _off(point: shapely.Point) -> float:
    return hypot(point.x, point.y)


def _outer(points: FloatArray, pad_m: float) -> shapely.Polygon:
    """A polygon of few corners around points (n, 2) that may be off by `pad_m` along both axes: their bounding box, or
    the half-planes of `SIDES` directions where that is much smaller."""
    (x0, y0), (x1, y1) = points.min(axis=0) - pad_m, points.max(axis=0) + pad_m
    box = shapely.box(x0, y0, x1, y1)
    angles = 2.0 * pi * np.arange(SIDES) / SIDES
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ends = (points @ normals.T).max(axis=0) + pad_m * np.abs(normals).sum(axis=1)
    corners = [
        np.linalg.solve(np.array([normals[k - 1], normals[k]]), np.array([ends[k - 1], ends[k]])) for k in range(SIDES)
    ]
    area = shapely.MultiPoint(np.array(corners)).convex_hull
    assert isinstance(area, shapely.Polygon), "a footprint has an area"
    return box if box.area <= BOX_SHARE * area.area else area


def _swept(points: FloatArray, low_rad: float, high_rad: float) -> FloatArray:
    """Points (n, 2) whose hull contains `points` at every heading between two: at headings at most `TURN_STEP_RAD`
    apart, farther out by the height of the arcs between them."""
    steps = ceil((high_rad - low_rad) / TURN_STEP_RAD)
    if steps == 0 and low_rad == 0.0:
        return points
    angles = np.linspace(low_rad, high_rad, steps + 1)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    turned = np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=-1)
    return turned.reshape(-1, 2) / cos((high_rad - low_rad) / (2.0 * max(steps, 1)))
