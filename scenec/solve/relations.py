"""Evaluates relations for placed things: amount of violation in metres or radians, in the background's frame B."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, hypot, pi, sin

import numpy as np

from scenec.ir.problem import RelationIR
from scenec.solve.frames import pose_of, turned_direction
from scenec.solve.placed import Placed, footprint_distance
from scenec.solve.planar import polygon
from schemas.arrays import FloatArray

NEAREST_M = 1e-5  # origins closer than this define no direction
SLACK = 1e-9  # metres or radians, for rounding


def direction_B(rule: RelationIR, assignment: Mapping[str, Placed]) -> tuple[float, float]:
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


def front_B(placed: Placed, assignment: Mapping[str, Placed]) -> float:
    """Heading of the asset's +x in B."""
    return pose_of(placed.parent, assignment).yaw_rad + placed.turned.yaw_rad + placed.turned.shape.front_rad


def wrapped(angle_rad: float) -> float:
    """An angle brought into [-pi, pi)."""
    return (angle_rad + pi) % (2 * pi) - pi


def excess(rule: RelationIR, assignment: Mapping[str, Placed]) -> float:
    """Violation of a relation: metres, or radians for facing; at most 0 where it holds. All things must be placed."""
    members = [assignment[name] for name in rule.things]
    if rule.kind == "before":
        direction = direction_B(rule, assignment)
        _, end = extent(members[0], direction, assignment)
        begin, _ = extent(members[1], direction, assignment)
        return end + rule.gap_m - begin
    if rule.kind in ("near", "far_from"):
        gap = distance(members[0], members[1], assignment) - rule.gap_m
        return gap if rule.kind == "near" else -gap
    points = [origin_B(placed, assignment) for placed in members]
    if rule.kind == "aligned":
        dx, dy = direction_B(rule, assignment)
        across = [-dy * x + dx * y for x, y in points]
        return max(across) - min(across) - rule.tolerance
    if rule.kind == "facing":
        if hypot(points[1][0] - points[0][0], points[1][1] - points[0][1]) < NEAREST_M:
            return pi
        heading = atan2(points[1][1] - points[0][1], points[1][0] - points[0][0])
        return abs(wrapped(heading - front_B(members[0], assignment))) - rule.tolerance
    (px, py), (ax, ay), (bx, by) = points  # between
    length = max(hypot(bx - ax, by - ay), 1e-12)
    ux, uy = (bx - ax) / length, (by - ay) / length
    along, beside = (px - ax) * ux + (py - ay) * uy, abs((py - ay) * ux - (px - ax) * uy)
    return max(-along, along - length, beside - rule.tolerance)
