"""`keep_clear`: the second thing, with all it carries, is nowhere in the space that a joint of the first one sweeps.

No word of `relations` writes it: the solver's model makes one for each pair (`scenec.solve.keep_clear`). The space
moves with the first thing, turned by its yaw; both may touch.
"""

from __future__ import annotations

from math import cos, sin
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from geom.convex_outlines import convex_outlines
from scenec.plan.cases.motions import Motions, RelativePoses, sway
from scenec.relations.protocol import Assignment, Batch, Mover, RelationMeaning
from scenec.solve.frames import Pose2, pose_of
from scenec.solve.measures import SLACK
from scenec.solve.planar import SLACK_M, hulls
from scenec.solve.region_geometry import in_P, minkowski_sum_points, widened
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.scene.geometry import KeepClear, PlaceLayer, SceneRelation


class KeepClearOf(RelationMeaning):
    """See the module."""

    kind = "keep_clear"
    slow_to_measure = True

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        """The side (m) of a square as large as what is entered, over all pairs of prisms."""
        owner, other = (assignment[name] for name in rule.things)
        zone_pose, base = pose_of(owner.name, assignment), pose_of(other.parent, assignment)
        entered_m2 = 0.0
        for layer in zone_of(rule).layers:
            low, high = zone_pose.z_m + layer.low_m, zone_pose.z_m + layer.high_m
            area = _moved(layer, zone_pose)
            for outline, other_low, other_high in other.prisms:
                if base.z_m + other_low < high - SLACK_M and base.z_m + other_high > low + SLACK_M:
                    entered_m2 = max(entered_m2, _entered_m2(area, _in_B(outline, base)))
        return entered_m2**0.5

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry:
        owner, other = rule.things
        no_fit = (
            _around_zone(rule, mover, pose_of(owner, assignment))
            if mover.name == other
            else _around_other(rule, mover, assignment)
        )
        return shapely.difference(shapely.box(*widened(mover.around)), shapely.union_all(no_fit))

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """Rectangles decide nothing: the space is no rectangle, and counts at some heights only."""
        return np.ones(batch.rects_m[0].shape[:-1], dtype=bool)

    @override
    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        return member == 0 or uneven

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """The least distance of the other thing from the space; 0 where it is touched or entered."""
        owner, other = motions.members
        value = np.full(len(owner.yaw_rad), np.inf)
        zone_z = _origin_z(owner)
        for layer in zone_of(rule).layers:
            for stance, shape in enumerate(other.shapes):
                for prism in shape.prisms:
                    met = (other.stance == stance) & (other.floor_m + prism.low_m < zone_z + layer.high_m - SLACK_M)
                    met &= other.floor_m + prism.high_m > zone_z + layer.low_m + SLACK_M
                    rows = np.flatnonzero(met)
                    if len(rows):
                        value[rows] = np.minimum(value[rows], _distances(layer, owner, prism.outline_m, other, rows))
        return value

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        owner, other = motions.members
        swing = owner.origin_m + sway(owner.turn_rad) * zone_radius_m(zone_of(rule))
        return value - (swing + other.outline_m + motions.rounding_m) >= 0.0


def zone_of(rule: SceneRelation) -> KeepClear:
    """The space of a rule of this kind."""
    assert rule.zone is not None, "rules of this kind have a space"
    return rule.zone


def zone_radius_m(zone: KeepClear) -> float:
    """Distance of the farthest point of a space from the origin of its owner, seen from above."""
    return max(float(np.hypot(*shapely.get_coordinates(layer.polygon).T).max()) for layer in zone.layers)


def _moved(layer: PlaceLayer, at: Pose2) -> BaseGeometry:
    """The area of a layer in B, its owner being at a pose in B."""
    return _transformed(layer.polygon, at.x_m, at.y_m, at.yaw_rad)


def _in_B(outline: BaseGeometry, base: Pose2) -> BaseGeometry:
    return outline if base == (0.0, 0.0, base.z_m, 0.0) else _transformed(outline, base.x_m, base.y_m, base.yaw_rad)


def _transformed(area: BaseGeometry, x_m: float, y_m: float, yaw_rad: float) -> BaseGeometry:
    c, s = cos(yaw_rad), sin(yaw_rad)
    turn_T = np.array([[c, s], [-s, c]])
    return shapely.transform(area, lambda points: points @ turn_T + (x_m, y_m))


def _entered_m2(area: BaseGeometry, outline: BaseGeometry) -> float:
    """Area of the overlap, 0 where a band of half the slack along both takes it all."""
    if not area.intersects(outline):
        return 0.0
    less = [shape.buffer(-SLACK_M / 2.0, join_style="mitre") for shape in (area, outline)]
    return max(float(less[0].intersection(less[1]).area), 4.0 * SLACK**2) if less[0].intersects(less[1]) else 0.0


def _around_zone(rule: SceneRelation, mover: Mover, at: Pose2) -> list[BaseGeometry]:
    """Where in P the origin of the other thing may not lie, the owner of the space being at a pose in B."""
    zone, floor = zone_of(rule), mover.owner.z_m + mover.base_P_m
    c, s = cos(at.yaw_rad), sin(at.yaw_rad)
    turn_T = np.array([[c, s], [-s, c]])
    points: list[FloatArray] = []
    for outline, prism in zip(mover.turned.outlines, mover.turned.shape.prisms, strict=True):
        met = _met(zone, floor + prism.low_m - at.z_m, floor + prism.high_m - at.z_m)
        placed = [in_P(part @ turn_T + (at.x_m, at.y_m), mover.owner) for part in met]
        points += [minkowski_sum_points(part, outline) for part in placed]
    return hulls(points)


def _around_other(rule: SceneRelation, mover: Mover, assignment: Assignment) -> list[BaseGeometry]:
    """Where in P the origin of the owner of the space may not lie, the other thing being placed."""
    zone, other = zone_of(rule), assignment[rule.things[1]]
    base = pose_of(other.parent, assignment)
    rise = base.z_m - (mover.owner.z_m + mover.base_P_m + mover.turned.shape.origin_height_m)
    c, s = cos(mover.turned.yaw_rad), sin(mover.turned.yaw_rad)
    turn_T = np.array([[c, s], [-s, c]])
    points: list[FloatArray] = []
    for outline, low, high in other.prisms:
        if met := _met(zone, rise + low, rise + high):
            placed = in_P(shapely.get_coordinates(_in_B(outline, base))[:-1], mover.owner)
            points += [minkowski_sum_points(placed, part @ turn_T) for part in met]
    return hulls(points)


_MET: WeakKeyDictionary[KeepClear, dict[tuple[int, ...], list[FloatArray]]] = WeakKeyDictionary()


def _met(zone: KeepClear, low_m: float, high_m: float) -> list[FloatArray]:
    """Convex outlines whose union is the part of a space seen from above that has a height in common with a prism, in
    P of its owner; those inside of others are left out. Made once for each set of layers."""
    layers = zone.layers
    met = tuple(
        k for k, layer in enumerate(layers) if low_m < layer.high_m - SLACK_M and high_m > layer.low_m + SLACK_M
    )
    known = _MET.setdefault(zone, {})
    if met not in known:
        areas = sorted((layers[k].polygon for k in met), key=lambda area: -area.area)
        outer: list[Polygon] = []
        for area in areas:
            if not any(other.covers(area) for other in outer):
                outer.append(area)
        known[met] = [outline for area in outer for outline in convex_outlines(area)]
    return known[met]


def _origin_z(owner: RelativePoses) -> FloatArray:
    """(l,) height over the base's origin of the asset origin of the owner of the space."""
    return owner.floor_m + np.array([shape.origin_height_m for shape in owner.shapes])[owner.stance]


def _distances(
    layer: PlaceLayer, owner: RelativePoses, outline: FloatArray, other: RelativePoses, rows: IntArray
) -> FloatArray:
    """(r,) distances in some layouts between a layer and an outline of the other thing, seen from above; 0 where they
    meet."""
    c, s = np.cos(owner.yaw_rad[rows]), np.sin(owner.yaw_rad[rows])
    turn = other.yaw_rad[rows] - owner.yaw_rad[rows]
    shift = other.at_m[rows] - owner.at_m[rows]
    shift = np.stack([c * shift[:, 0] + s * shift[:, 1], c * shift[:, 1] - s * shift[:, 0]], axis=1)
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = outline.T
    placed = shapely.polygons(np.stack([c * x - s * y, s * x + c * y], axis=-1) + shift[:, None])
    shapely.prepare(layer.polygon)
    return np.asarray(shapely.distance(layer.polygon, placed))


RELATION = KeepClearOf()
