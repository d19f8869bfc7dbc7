"""Measures placed things in the background's frame B: extents, origins, distances, fronts, in metres and radians."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import cos, pi, sin

import numpy as np
from shapely.geometry.base import BaseGeometry

from scenec.solve.frames import Pose2, pose_of, turned_direction
from scenec.solve.placed import Placed, footprint_distance
from scenec.solve.planar import hulls, polygon
from scenec.solve.region_geometry import in_P, minkowski_sum_points
from scenec.solve.shapes import ShapeAtYaw
from schemas.arrays import FloatArray
from schemas.scene.geometry import SceneRelation

SLACK = 1e-9  # metres or radians, for rounding


def direction_B(rule: SceneRelation, assignment: Mapping[str, Placed]) -> tuple[float, float]:
    """The direction of a relation in B; the thing that defines its frame must be placed."""
    return turned_direction(rule.direction, pose_of(rule.frame, assignment).yaw_rad)


def extent(placed: Placed, direction: tuple[float, float], assignment: Mapping[str, Placed]) -> tuple[float, float]:
    """Interval (begin, end) of the footprint of a placed thing along a direction of B."""
    owner = pose_of(placed.parent, assignment)
    dx, dy = turned_direction(direction, -owner.yaw_rad)
    x0, y0, x1, y1 = placed.bounds
    start = owner.x_m * direction[0] + owner.y_m * direction[1]
    if dy == 0.0:
        return (start + dx * x0, start + dx * x1) if dx > 0 else (start + dx * x1, start + dx * x0)
    if dx == 0.0:
        return (start + dy * y0, start + dy * y1) if dy > 0 else (start + dy * y1, start + dy * y0)
    along = placed.turned.hull @ (dx, dy)
    start += placed.x_P_m * dx + placed.y_P_m * dy
    return start + float(along.min()), start + float(along.max())


def origin_B(placed: Placed, assignment: Mapping[str, Placed]) -> tuple[float, float]:
    """Asset origin of a placed thing in B, from above."""
    return pose_of(placed.parent, assignment).point(placed.x_P_m, placed.y_P_m)


def origins_B(names: Iterable[str], assignment: Mapping[str, Placed]) -> list[tuple[float, float]]:
    """Asset origins of placed things in B, from above."""
    return [origin_B(assignment[name], assignment) for name in names]


def mates_P(
    rule: SceneRelation, name: str, owner: Pose2, assignment: Mapping[str, Placed]
) -> list[tuple[float, float]]:
    """Origins of the other members of a relation in the frame P of the owner of one."""
    return [owner.inverse_point(*point) for point in origins_B((n for n in rule.things if n != name), assignment)]


def no_fit_of_mate(
    rule: SceneRelation, name: str, turned: ShapeAtYaw, owner: Pose2, assignment: Mapping[str, Placed]
) -> list[BaseGeometry]:
    """Areas in P whose union is where the origin of a member may not lie if it must not meet the other member."""
    (mate,) = (assignment[n] for n in rule.things if n != name)
    return hulls(
        [
            minkowski_sum_points(in_P(outline, owner), mine)
            for outline in outlines_B(mate, assignment)
            for mine in turned.pieces
        ]
    )


def distance(a: Placed, b: Placed, assignment: Mapping[str, Placed]) -> float:
    """Least distance (m) of two whole footprints on any owners."""
    if a.parent == b.parent:
        return footprint_distance(a, b)
    pieces_a, pieces_b = (outlines_B(placed, assignment) for placed in (a, b))
    return min(p.distance(q) for p in map(polygon, pieces_a) for q in map(polygon, pieces_b))


def outlines_B(placed: Placed, assignment: Mapping[str, Placed]) -> list[FloatArray]:
    """Convex pieces of the footprint in B, each (n, 2)."""
    owner = pose_of(placed.parent, assignment)
    c, s = cos(owner.yaw_rad), sin(owner.yaw_rad)
    turn_T = np.array([[c, s], [-s, c]])
    shift = (placed.x_P_m, placed.y_P_m)
    return [(piece + shift) @ turn_T + (owner.x_m, owner.y_m) for piece in placed.turned.pieces]


def heights_B(placed: Placed, assignment: Mapping[str, Placed]) -> tuple[float, float]:
    """Lowest and highest z in B of a placed thing, without what it carries."""
    floor = pose_of(placed.parent, assignment).z_m + placed.base_P_m
    return floor + placed.turned.shape.own_low_m, floor + placed.turned.shape.own_high_m


def front_B(placed: Placed, assignment: Mapping[str, Placed]) -> float:
    """Heading of the asset's +x in B."""
    return pose_of(placed.parent, assignment).yaw_rad + placed.turned.yaw_rad + placed.turned.shape.front_rad


def wrapped(angle_rad: float) -> float:
    """An angle brought into [-pi, pi)."""
    return (angle_rad + pi) % (2 * pi) - pi
