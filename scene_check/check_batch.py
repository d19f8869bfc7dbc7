"""Violations of n scenes: conservative bounds prove most scenes valid, the exact judge checks the others one by one.

The bounds replace the pieces of an object by their convex hull, their heights by its whole height, and hulls by boxes.
They are one-sided: a scene that passes is valid by every rule of `check_scene`. So the violations are those of the
exact judge, and a valid scene costs microseconds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from geom.planar import front_of
from geom.polygon_measures import distances
from scene_check import Violation, check
from scene_check.batch import BatchPoses, SceneRules, ThingRule, scene_at
from scene_check.model import TOLERANCE_M, TURN
from scene_check.relations import PREDICATES, SLACK_M, BatchMembers
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.scene.geometry import BACKGROUND, KeepClear, KeepOutVolume, ScenePlace, SceneRelation

NEAREST_PIECES = 4  # of a footprint that are compared with those of another: more cost as much as the exact judge


@dataclass(frozen=True)
class FootprintBounds:
    """Bounds of T objects in n scenes: hull corners (n, v, 2) in W for each object, lowest and highest z (n, T)."""

    hulls: tuple[FloatArray, ...]
    low_m: FloatArray
    high_m: FloatArray


def check_batch(rules: SceneRules, poses: BatchPoses) -> Iterator[tuple[int, tuple[Violation, ...]]]:
    """Number and violations of every scene that has any, in order."""
    for k in np.flatnonzero(unproven(rules, poses)).tolist():
        violations = check(scene_at(rules, poses, k))
        if violations:
            yield k, violations


def unproven(rules: SceneRules, poses: BatchPoses) -> BoolArray:
    """(n,) True for the scenes that no bound proves valid."""
    n = len(poses.origin_m)
    if not rules.things:
        return np.zeros(n, dtype=bool)
    footprints = _footprint_bounds(rules, poses)
    bad = ~poses.known.all(axis=1)
    bad |= bool(rules.stacks or rules.grids)  # They have no bound: the exact judge decides.
    for i, thing in enumerate(rules.things):
        bad |= _allowed(rules, poses, i, thing)
        bad |= _places(rules, poses, footprints, i)
    bad |= _pairs(rules, poses, footprints)
    for rule in rules.relations:
        bad |= ~_related(rules, poses, footprints, rule)
    for keep_out in rules.keep_outs:
        bad |= _kept_out(rules, poses, footprints, keep_out)
    for space in rules.keep_clear:
        bad |= _swept(rules, poses, footprints, space)
    if rules.reach is not None:
        members = [i for i, thing in enumerate(rules.things) if thing.name in rules.reach.members]
        away = np.hypot(*np.moveaxis(poses.origin_m[:, members, :2] - rules.reach.base_m[:2], -1, 0))
        bad |= ((away > rules.reach.most_m + SLACK_M) | (away < rules.reach.least_m - SLACK_M)).any(axis=1)
    return bad


def _footprint_bounds(rules: SceneRules, poses: BatchPoses) -> FootprintBounds:
    hulls: list[FloatArray] = []
    low: list[FloatArray] = []
    high: list[FloatArray] = []
    for i, thing in enumerate(rules.things):
        index = poses.form[:, i]
        outlines = [_hull(np.vstack([p.outline_m for p in form.prisms])) for _, form in thing.forms]
        most = max(len(outline) for outline in outlines)
        corners = np.stack([_padded(outline, most) for outline in outlines])
        at = poses.origin_m[:, i]
        hulls.append(_turned(corners[index], poses.yaw_rad[:, i]) + at[:, None, :2])
        floor = at[:, 2] - np.array([form.origin_height_m for _, form in thing.forms])[index]
        low.append(floor + np.array([min(p.low_m for p in form.prisms) for _, form in thing.forms])[index])
        high.append(floor + np.array([max(p.high_m for p in form.prisms) for _, form in thing.forms])[index])
    return FootprintBounds(tuple(hulls), np.stack(low, axis=1), np.stack(high, axis=1))


def _hull(points: FloatArray) -> FloatArray:
    """Convex hull (v, 2) of points, counter-clockwise."""
    return np.asarray(shapely.get_coordinates(shapely.orient_polygons(shapely.MultiPoint(points).convex_hull)))[:-1]


def _pieces_near(rules: SceneRules, poses: BatchPoses, i: int, points_W: FloatArray) -> list[FloatArray]:
    """Corners (n, v, 2) of pieces of the footprint of object i: in each scene those nearest to a point (n, 2), as far
    as circles around them show, the nearest first."""
    pieces = [[prism.outline_m for prism in form.prisms] for _, form in rules.things[i].forms]
    count, most = max(map(len, pieces)), max(len(outline) for form in pieces for outline in form)
    # Forms with fewer pieces repeat their last one, pieces with fewer corners their first one: (form, piece, v, 2).
    corners = np.array([
        [_padded(form[min(k, len(form) - 1)], most) for k in range(count)] for form in pieces
    ])  # fmt: skip
    middles = corners.mean(axis=2)
    radii = np.hypot(*np.moveaxis(corners - middles[:, :, None], -1, 0)).max(axis=2)
    form, yaw = poses.form[:, i], poses.yaw_rad[:, i]
    away = _turned(points_W[:, None] - poses.origin_m[:, i, None, :2], -yaw) - middles[form]
    order = np.argsort(np.hypot(away[..., 0], away[..., 1]) - radii[form], axis=1)[:, :NEAREST_PIECES]
    return [_turned(corners[form, order[:, k]], yaw) + poses.origin_m[:, i, None, :2] for k in range(order.shape[1])]


def _padded(outline: FloatArray, count: int) -> FloatArray:
    """An outline with its first corner repeated up to a number of corners."""
    return np.vstack([outline, np.repeat(outline[:1], count - len(outline), axis=0)])


def _turned(points: FloatArray, yaw_rad: FloatArray) -> FloatArray:
    """Points (n, v, 2) rotated by n yaws."""
    c, s = np.cos(yaw_rad)[:, None], np.sin(yaw_rad)[:, None]
    return np.stack([c * points[..., 0] - s * points[..., 1], s * points[..., 0] + c * points[..., 1]], axis=-1)


def _owner(rules: SceneRules, poses: BatchPoses, name: str) -> tuple[FloatArray, FloatArray]:
    """Origins (n or 1, 3) and yaws (n or 1,) in W of an owner."""
    if name == BACKGROUND:
        return rules.origin_m[None], np.array([rules.yaw_rad])
    return poses.origin_m[:, rules.number[name]], poses.yaw_rad[:, rules.number[name]]


def _in_place(
    rules: SceneRules, poses: BatchPoses, owner: str, place: ScenePlace, points_W: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (n, v, 2) in A of a place, its height (n or 1,) and its yaw (n or 1,) in W."""
    origin, yaw = _owner(rules, poses, owner)
    inside = _turned(points_W - origin[:, None, :2], -yaw) - place.origin_P_m[:2]
    return inside, origin[:, 2] + place.origin_P_m[2], yaw


def _allowed(rules: SceneRules, poses: BatchPoses, i: int, thing: ThingRule) -> BoolArray:
    """(n,) True where ranges, fixed poses or stances of object i are not proven to hold."""
    stance = np.array([number for number, _ in thing.forms])[poses.form[:, i]]
    domain = thing.domain
    if domain.fixed_poses:
        return _off_fixed_poses(rules, poses, i, thing, stance)
    bad = ~np.isin(stance, domain.orientation_indices)
    points, _, turn = _in_place(rules, poses, thing.owner, thing.place, poses.origin_m[:, i, None, :2])
    at = points[:, 0]
    for axis, (low, high) in enumerate((domain.x_m, domain.y_m)):
        bad |= (at[:, axis] < low - SLACK_M) | (at[:, axis] > high + SLACK_M)
    if domain.yaw_rad[1] - domain.yaw_rad[0] < TURN:
        bad |= _turn(poses.yaw_rad[:, i] - turn, *domain.yaw_rad) > SLACK_M
    return bad


def _turn(angle: FloatArray, low: float, high: float) -> FloatArray:
    past = (angle - low) % TURN
    return np.maximum(0.0, np.minimum(past - (high - low), TURN - past))


def _off_fixed_poses(rules: SceneRules, poses: BatchPoses, i: int, thing: ThingRule, stance: IntArray) -> BoolArray:
    at, floor, turn = _in_place(rules, poses, thing.owner, thing.place, poses.origin_m[:, i, None, :2])
    z, yaw = poses.origin_m[:, i, 2] - floor, poses.yaw_rad[:, i] - turn
    least = np.full(len(stance), np.inf)
    for pose in thing.domain.fixed_poses:
        off = np.maximum(np.abs(at[:, 0] - (pose.x_m, pose.y_m)).max(axis=1), np.abs(z - pose.z_m))
        off = np.maximum(off, _turn(yaw, pose.yaw_rad, pose.yaw_rad))
        least = np.where(stance == pose.stance, np.minimum(least, off), least)
    return least > SLACK_M


def _places(rules: SceneRules, poses: BatchPoses, footprints: FootprintBounds, i: int) -> BoolArray:
    """(n,) True where object i is not proven to be supported and clear of the geometry of all its owners."""
    thing = rules.things[i]
    has_fixed_pose = bool(thing.domain.fixed_poses)
    bad = np.zeros(len(footprints.low_m), dtype=bool)
    direct = True
    while True:
        place = thing.place
        hull, floor, _ = _in_place(rules, poses, thing.owner, place, footprints.hulls[i])
        low, high = footprints.low_m[:, i] - floor, footprints.high_m[:, i] - floor
        if direct or not place.layers:
            bad |= high > place.height_m + SLACK_M
        if direct:
            if not has_fixed_pose:
                bad |= np.abs(low) > SLACK_M  # lower: inside the owner; higher: on other contents, if any
            if not place.is_volume:
                off = ~_covered(hull, place.polygon)
                bad |= off & (np.abs(low) <= TOLERANCE_M + SLACK_M) if has_fixed_pose else off
        for layer_low, layer_high, polygon in place.layers:
            meets = np.minimum(high, layer_high) - np.maximum(low, layer_low) > SLACK_M
            bad |= meets & ~_covered(hull, polygon)
        for part in place.above:
            meets = np.minimum(high, part.high_m) - np.maximum(low, part.low_m) > SLACK_M
            if meets.any():
                bad |= meets & (_gap_to(hull, part.outline_m) < -SLACK_M)
        if thing.owner == BACKGROUND:
            return bad
        thing, direct = rules.things[rules.number[thing.owner]], False


def _covered(hulls: FloatArray, polygon: Polygon) -> BoolArray:
    """(n,) True where convex hulls (n, v, 2) lie on a polygon grown by the slack."""
    if not polygon.interiors and np.isclose(polygon.convex_hull.area, polygon.area, rtol=1e-12):
        outline = _hull(np.asarray(polygon.exterior.coords))
        return _beyond(hulls, outline).max(axis=(1, 2)) <= SLACK_M
    grown = polygon.buffer(SLACK_M, join_style="mitre")
    shapely.prepare(grown)
    return np.asarray(shapely.covers(grown, shapely.polygons(hulls)))


def _beyond(points: FloatArray, outline: FloatArray) -> FloatArray:
    """Signed distances (n, v, e) of points (n, v, 2) outside each edge of a convex outline (e, 2)."""
    edges = np.roll(outline, -1, axis=0) - outline
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)[lengths > 0.0] / lengths[lengths > 0.0, None]
    return points @ normals.T - np.einsum("ed,ed->e", normals, outline[lengths > 0.0])


def _gap_to(hulls: FloatArray, outline: FloatArray) -> FloatArray:
    """(n,) largest gap between hulls and a fixed convex outline along the normals of the outline."""
    return _beyond(hulls, outline).min(axis=1).max(axis=1)


def _pairs(rules: SceneRules, poses: BatchPoses, footprints: FootprintBounds) -> BoolArray:
    """(n,) True where a clearance is not proven."""
    n, count = footprints.low_m.shape
    c, s = np.cos(rules.yaw_rad), np.sin(rules.yaw_rad)
    axes = np.array([[c, -s], [s, c]])  # of the background: objects on it are separated along its axes
    least = np.stack([(hull @ axes).min(axis=1) for hull in footprints.hulls], axis=1)  # (n, T, 2)
    most = np.stack([(hull @ axes).max(axis=1) for hull in footprints.hulls], axis=1)
    bound = rules.clearance_m - SLACK_M
    bad = np.zeros(n, dtype=bool)
    owners = [_owners(rules, i) for i in range(count)]
    for i in range(count - 1):
        others = np.array([j for j in range(i + 1, count) if j not in owners[i] and i not in owners[j]], dtype=np.int64)
        if not others.size:
            continue
        near = np.maximum(footprints.low_m[:, others], footprints.low_m[:, i, None]) + SLACK_M < np.minimum(
            footprints.high_m[:, others], footprints.high_m[:, i, None]
        )
        for axis in range(2):
            near &= least[:, others, axis] - most[:, i, axis, None] < bound
            near &= least[:, i, axis, None] - most[:, others, axis] < bound
        for row in np.flatnonzero(near.any(axis=0)):
            scenes = np.flatnonzero(near[:, row] & ~bad)
            outline_a = shapely.polygons(footprints.hulls[i][scenes])
            outline_b = shapely.polygons(footprints.hulls[int(others[row])][scenes])
            bad[scenes[distances(outline_a, outline_b) < max(bound, SLACK_M)]] = True
    return bad


def _owners(rules: SceneRules, i: int) -> set[int]:
    owners: set[int] = set()
    while (owner := rules.things[i].owner) != BACKGROUND:
        i = rules.number[owner]
        owners.add(i)
    return owners


def _related(rules: SceneRules, poses: BatchPoses, footprints: FootprintBounds, rule: SceneRelation) -> BoolArray:
    """(n,) True where a relation is proven to hold."""
    n = len(footprints.low_m)
    turn = np.broadcast_to(_owner(rules, poses, rule.frame)[1], (n,))
    numbers = [rules.number[name] for name in rule.things]
    members = BatchMembers(
        hulls=[footprints.hulls[i] for i in numbers],
        low_m=[footprints.low_m[:, i] for i in numbers],
        high_m=[footprints.high_m[:, i] for i in numbers],
        origins=[poses.origin_m[:, i, :2] for i in numbers],
        front_of=lambda k: _fronts(rules, poses, numbers[k]),
        along=_turned(np.broadcast_to(rule.direction, (n, 1, 2)), turn)[:, 0],
        is_hull=all(len(form.prisms) == 1 for i in numbers for _, form in rules.things[i].forms),
        pieces_near=lambda k, points_W: _pieces_near(rules, poses, numbers[k], points_W),
    )
    return PREDICATES[rule.kind].proven(rule, members)


def _fronts(rules: SceneRules, poses: BatchPoses, i: int) -> FloatArray:
    """Directions (n, 2) in W of the front of object i."""
    fronts = np.stack([front_of(form.quat_wxyz) for _, form in rules.things[i].forms])[poses.form[:, i]]
    return _turned(fronts[:, None], poses.yaw_rad[:, i])[:, 0]


def _kept_out(rules: SceneRules, poses: BatchPoses, footprints: FootprintBounds, rule: KeepOutVolume) -> BoolArray:
    """(n,) True where an object may be over a keep-out."""
    owner = rules.number.get(rule.parent)
    exempt: set[int] = set() if owner is None else {owner} | _owners(rules, owner)
    bad = np.zeros(len(footprints.low_m), dtype=bool)
    for i in range(len(rules.things)):
        if i in exempt:
            continue
        hull, floor, _ = _in_place(rules, poses, rule.parent, rule.place, footprints.hulls[i])
        meets = np.minimum(footprints.high_m[:, i] - floor, rule.height_m) - np.maximum(
            footprints.low_m[:, i] - floor, 0.0
        )
        bad |= (meets > SLACK_M) & (distances(rule.polygon, shapely.polygons(hull)) <= 0.0)
    return bad


def _swept(rules: SceneRules, poses: BatchPoses, footprints: FootprintBounds, space: KeepClear) -> BoolArray:
    """(n,) True where an object may be in the space that a joint sweeps."""
    owner = rules.number.get(space.owner)
    exempt: set[int] = set() if owner is None else {owner} | _owners(rules, owner)
    origin, yaw = _owner(rules, poses, space.owner)
    bad = np.zeros(len(footprints.low_m), dtype=bool)
    for i in range(len(rules.things)):
        if i in exempt or _rides(rules, i, space):
            continue
        hull = shapely.polygons(_turned(footprints.hulls[i] - origin[:, None, :2], -yaw))
        for layer in space.layers:
            low, high = origin[:, 2] + layer.low_m, origin[:, 2] + layer.high_m
            meets = np.minimum(footprints.high_m[:, i], high) - np.maximum(footprints.low_m[:, i], low) > SLACK_M
            if meets.any():
                bad |= meets & (distances(layer.polygon, hull) <= 0.0)
    return bad


def _rides(rules: SceneRules, i: int, space: KeepClear) -> bool:
    """Whether object i, or what carries it, is on a place that moves with the joint of a swept space."""
    while True:
        thing = rules.things[i]
        if thing.owner == space.owner:
            return thing.place.link in space.links
        if thing.owner == BACKGROUND:
            return False
        i = rules.number[thing.owner]
