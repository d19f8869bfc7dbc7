"""The independent judge of a finished scene: plain arrays in, violations out; it knows no compiler and no solver.

An object is a set of convex prisms in the world W (metres, z up). Places are level, so frame A of a place is an origin
and a yaw in W. What is judged, and against which bound (`TOLERANCE_M` for lengths, the same number in rad for angles):

support     on a surface it stands on the polygon with every outline, its top under the free height; in a volume each
            prism lies within every layer that it spans and below the rim, on the floor or on what lies there
clearance   least distance of footprints between objects that overlap in height: whole footprints and whole heights for
            objects of one place, prism by prism otherwise. Objects are not held apart from their owners, nor the
            owners' owners: there only the owner's geometry over the place (`above`) must not be entered
ranges, stances, spots, relations, keep-outs, reach (a ring in x and y). A spot written off the floor (a hook, a peg
            hole) needs no support beneath it: its author has said that it holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

FloatArray = NDArray[np.float64]
TOLERANCE_M = 1e-6
TURN = 2.0 * np.pi
ViolationKind = Literal[
    "off_support", "unsupported", "headroom", "outside_volume", "owner_entered", "clearance", "penetration",
    "relation", "keep_out", "reach", "range", "spot", "stance",
]  # fmt: skip


@dataclass(frozen=True)
class CheckPrism:
    """A convex outline (n, 2) counter-clockwise and the heights between which it stands, in W (or A where said)."""

    outline_m: FloatArray
    low_m: float
    high_m: float


@dataclass(frozen=True)
class CheckPlace:
    """Where objects stand: `origin_m` (3,) and `yaw_rad` of A in W; `polygon` (with holes), `layers` (low, high,
    polygon) and `above` in A. A surface has a polygon, a volume has layers; `height_m` is free height or rim."""

    owner: str
    name: str
    origin_m: FloatArray
    yaw_rad: float
    polygon: Polygon | None = None
    layers: tuple[tuple[float, float, Polygon], ...] = ()
    height_m: float = np.inf
    above: tuple[CheckPrism, ...] = ()


@dataclass(frozen=True)
class CheckObject:
    """One object as it stands: origin of its asset frame (3,) and direction of its front (2,) in W, its prisms in W,
    what its program allows: ranges of x, y, yaw in A, or `spots` (x, y, z, yaw) in A, and stances by number."""

    name: str
    prisms: tuple[CheckPrism, ...]
    origin_m: FloatArray
    yaw_rad: float
    front: FloatArray
    place: CheckPlace
    x_m: tuple[float, float] = (-np.inf, np.inf)
    y_m: tuple[float, float] = (-np.inf, np.inf)
    yaw_range_rad: tuple[float, float] = (-np.pi, np.pi)
    spots: tuple[tuple[float, float, float, float], ...] = ()
    stance: int = 0
    stances: tuple[int, ...] = (0,)

    @property
    def low_m(self) -> float:
        """Height of the lowest point in W."""
        return min(prism.low_m for prism in self.prisms)

    @property
    def high_m(self) -> float:
        """Height of the highest point in W."""
        return max(prism.high_m for prism in self.prisms)


@dataclass(frozen=True)
class CheckRelation:
    """`before`, `near`, `far_from`, `aligned`, `facing` or `between` over names; `direction` (2,) is unit and in W."""

    kind: str
    objects: tuple[str, ...]
    direction: FloatArray
    gap_m: float = 0.0
    tolerance: float = 0.0
    label: str = ""


@dataclass(frozen=True)
class CheckKeepOut:
    """Nothing may be over `polygon` (in A of `place`) from the place to `height_m` above it, its owners excepted."""

    place: CheckPlace
    polygon: Polygon
    height_m: float
    label: str = ""


@dataclass(frozen=True)
class CheckReach:
    """Origins of `objects` lie between `least_m` and `most_m` from `base_m`, seen from above."""

    base_m: FloatArray
    least_m: float
    most_m: float
    objects: tuple[str, ...]


@dataclass(frozen=True)
class CheckScene:
    """All that stands; what does not move is known by the places on it."""

    objects: tuple[CheckObject, ...]
    clearance_m: float
    relations: tuple[CheckRelation, ...] = ()
    keep_outs: tuple[CheckKeepOut, ...] = ()
    reach: CheckReach | None = None


@dataclass(frozen=True)
class Violation:
    """What is broken, by which objects, the value found against its bound in `unit`."""

    kind: ViolationKind
    names: tuple[str, ...]
    value: float
    bound: float
    unit: str = "m"
    label: str = ""


def check(scene: CheckScene) -> tuple[Violation, ...]:
    """Every violation of the scene, in the order of its objects; none means that the scene is valid."""
    by_name = {item.name: item for item in scene.objects}
    found: list[Violation] = []
    for item in scene.objects:
        found += _pose(item)
        found += _support(item, scene)
        found += _owners(item, by_name)
    found += _pairs(scene, by_name)
    for relation in scene.relations:
        found += _relation(relation, [by_name[name] for name in relation.objects])
    for keep_out in scene.keep_outs:
        found += _keep_out(keep_out, scene, by_name)
    if scene.reach is not None:
        found += _reach(scene.reach, by_name)
    return tuple(found)


# One object and its place.


def _pose(item: CheckObject) -> Iterator[Violation]:
    x, y = _to_place(item.origin_m[None, :2], item.place)[0]
    z, yaw = item.origin_m[2] - item.place.origin_m[2], item.yaw_rad - item.place.yaw_rad
    if item.stance not in item.stances:
        yield Violation("stance", (item.name,), item.stance, item.stances[0], "", "stance")
    if item.spots:
        off = min(max(abs(x - sx), abs(y - sy), abs(z - sz), _turn(yaw, sa, sa)) for sx, sy, sz, sa in item.spots)
        if off > TOLERANCE_M:
            yield Violation("spot", (item.name,), off, 0.0, "m", "spot")
        return
    for axis, value, (low, high) in (("x", x, item.x_m), ("y", y, item.y_m)):
        if not low - TOLERANCE_M <= value <= high + TOLERANCE_M:
            yield Violation("range", (item.name,), float(value), low if value < low else high, "m", axis)
    if _turn(yaw, *item.yaw_range_rad) > TOLERANCE_M:
        yield Violation("range", (item.name,), float(yaw), item.yaw_range_rad[0], "rad", "yaw")


def _turn(angle: float, low: float, high: float) -> float:
    """How far an angle lies outside [low, high], whole turns apart."""
    past = (angle - low) % TURN
    return max(0.0, min(past - (high - low), TURN - past))


def _support(item: CheckObject, scene: CheckScene) -> Iterator[Violation]:
    place = item.place
    low, high = item.low_m - place.origin_m[2], item.high_m - place.origin_m[2]
    if high > place.height_m + TOLERANCE_M:
        yield Violation("headroom", (item.name, place.owner), float(high), place.height_m)
    if low < -TOLERANCE_M and not item.spots:
        yield Violation("owner_entered", (item.name, place.owner), float(-low), 0.0)
    if place.polygon is not None and not (item.spots and abs(low) > TOLERANCE_M):
        out = max(_outside(_to_place(prism.outline_m, place), place.polygon) for prism in item.prisms)
        if out > 0.0:
            yield Violation("off_support", (item.name, place.owner), out, 0.0)
    if low > TOLERANCE_M and not item.spots and not (place.layers and _stands_on_contents(item, scene)):
        yield Violation("unsupported", (item.name, place.owner), float(low), 0.0)


def _stands_on_contents(item: CheckObject, scene: CheckScene) -> bool:
    """Whether the middle of the footprint lies over the hull of what it touches from above in the same place."""
    footprint = shapely.union_all([Polygon(prism.outline_m) for prism in item.prisms])
    touched = [
        Polygon(prism.outline_m).intersection(footprint)
        for other in scene.objects
        if other is not item and _same_place(other.place, item.place)
        for prism in other.prisms
        if abs(prism.high_m - item.low_m) <= TOLERANCE_M
    ]
    return bool(touched) and shapely.union_all(touched).convex_hull.buffer(TOLERANCE_M).covers(footprint.centroid)


def _owners(item: CheckObject, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Entries into the geometry of owners: what rises over the place, layers of volumes, shelves above."""
    place, direct = item.place, True
    while True:
        floor = float(place.origin_m[2])
        top = item.high_m - floor
        if not direct and not place.layers and top > place.height_m + TOLERANCE_M:
            yield Violation("headroom", (item.name, place.owner), top, place.height_m)
        outlines = [_to_place(prism.outline_m, place) for prism in item.prisms]
        spans = [(prism.low_m - floor, prism.high_m - floor) for prism in item.prisms]
        out = max(
            (
                _outside(outline, polygon)
                for outline, span in zip(outlines, spans, strict=True)
                for low, high, polygon in place.layers
                if _overlap(span, (low, high))
            ),
            default=0.0,
        )
        if out > 0.0:
            yield Violation("outside_volume", (item.name, place.owner), out, 0.0)
        depth = max(
            (
                -_separation(outline, part.outline_m)
                for outline, span in zip(outlines, spans, strict=True)
                for part in place.above
                if _overlap(span, (part.low_m, part.high_m))
            ),
            default=0.0,
        )
        if depth > TOLERANCE_M:
            yield Violation("owner_entered", (item.name, place.owner), depth, 0.0)
        if place.owner not in by_name:
            return
        place, direct = by_name[place.owner].place, False


# Two objects.


def _pairs(scene: CheckScene, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Clearance and penetration between objects that are not each other's owners."""
    parts = [(k, prism) for k, item in enumerate(scene.objects) for prism in item.prisms]
    if not parts:
        return
    owner = np.array([k for k, _ in parts])
    low, high = np.array([p.low_m for _, p in parts]), np.array([p.high_m for _, p in parts])
    polygons = _polygons([p.outline_m for _, p in parts])
    one, two = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=scene.clearance_m)
    keep = owner[one] < owner[two]
    one, two = one[keep], two[keep]
    meet = np.minimum(high[one], high[two]) - np.maximum(low[one], low[two]) > TOLERANCE_M
    judged = _judged(scene.objects, by_name)
    worst: dict[tuple[int, int], tuple[float, float]] = {}
    for i, j, overlap in zip(one.tolist(), two.tolist(), meet.tolist(), strict=True):
        a, b = int(owner[i]), int(owner[j])
        how = judged(a, b)
        if how == "owner" or (how == "apart" and not overlap):
            continue
        distance = float(shapely.distance(polygons[i], polygons[j]))
        value = distance if distance > 0.0 else _separation(parts[i][1].outline_m, parts[j][1].outline_m)
        least, deepest = worst.get((a, b), (np.inf, 0.0))
        worst[a, b] = (min(least, value), max(deepest, -value if overlap else 0.0))
    names = [item.name for item in scene.objects]
    for (a, b), (value, depth) in sorted(worst.items()):
        if depth > TOLERANCE_M:
            yield Violation("penetration", (names[a], names[b]), depth, 0.0)
        elif value < scene.clearance_m - TOLERANCE_M:
            yield Violation("clearance", (names[a], names[b]), value, scene.clearance_m)


def _judged(
    objects: tuple[CheckObject, ...], by_name: dict[str, CheckObject]
) -> Callable[[int, int], Literal["owner", "whole", "apart"]]:
    """How two objects are judged: `owner` (not here), `whole` (of one place, heights overlap), `apart` (by prisms)."""
    spans = [(item.low_m, item.high_m) for item in objects]
    owners = [_owners_of(item, by_name) for item in objects]

    def judged(a: int, b: int) -> Literal["owner", "whole", "apart"]:
        if objects[b].name in owners[a] or objects[a].name in owners[b]:
            return "owner"
        same = _same_place(objects[a].place, objects[b].place) and _overlap(spans[a], spans[b])
        return "whole" if same else "apart"

    return judged


def _owners_of(item: CheckObject, by_name: dict[str, CheckObject]) -> frozenset[str]:
    names: list[str] = []
    while item.place.owner in by_name and item.place.owner not in names:
        names.append(item.place.owner)
        item = by_name[item.place.owner]
    return frozenset(names)


def _same_place(one: CheckPlace, two: CheckPlace) -> bool:
    return (one.owner, one.name) == (two.owner, two.name)


# Relations, keep-outs, reach.


def _relation(relation: CheckRelation, items: list[CheckObject]) -> Iterator[Violation]:
    value, bound, ok, unit = _relation_value(relation, items)
    if not ok:
        yield Violation("relation", relation.objects, value, bound, unit, relation.label or relation.kind)


def _relation_value(relation: CheckRelation, items: list[CheckObject]) -> tuple[float, float, bool, str]:
    """(value, bound, whether it holds, unit) of one relation."""
    origins = np.array([item.origin_m[:2] for item in items])
    along, across = np.asarray(relation.direction), np.array([-relation.direction[1], relation.direction[0]])
    if relation.kind == "before":
        end = max(float((prism.outline_m @ along).max()) for prism in items[0].prisms)
        begin = min(float((prism.outline_m @ along).min()) for prism in items[1].prisms)
        return begin - end, relation.gap_m, begin - end >= relation.gap_m - TOLERANCE_M, "m"
    if relation.kind in ("near", "far_from"):
        one, two = (shapely.union_all(_polygons([p.outline_m for p in item.prisms])) for item in items[:2])
        distance = float(one.distance(two))
        excess = distance - relation.gap_m if relation.kind == "near" else relation.gap_m - distance
        return distance, relation.gap_m, excess <= TOLERANCE_M, "m"
    if relation.kind == "aligned":
        offset = float(np.ptp(origins @ across))
        return offset, relation.tolerance, offset <= relation.tolerance + TOLERANCE_M, "m"
    if relation.kind == "facing":
        toward, front = origins[1] - origins[0], items[0].front
        angle = float(abs(np.arctan2(front[0] * toward[1] - front[1] * toward[0], front @ toward)))
        seen = min(np.hypot(*toward), np.hypot(*front)) > TOLERANCE_M
        return angle, relation.tolerance, bool(seen) and angle <= relation.tolerance + TOLERANCE_M, "rad"
    if relation.kind == "between":
        line = origins[2] - origins[1]
        length = float(np.hypot(*line))
        if length <= TOLERANCE_M:
            return 0.0, relation.tolerance, False, "m"
        step = origins[0] - origins[1]
        past, beside = float(step @ line) / length, abs(float(step[0] * line[1] - step[1] * line[0])) / length
        beyond = max(-past, past - length, 0.0)
        inside = beyond <= TOLERANCE_M and beside <= relation.tolerance + TOLERANCE_M
        return max(beyond, beside), relation.tolerance, inside, "m"
    raise ValueError(f"unknown relation kind {relation.kind}")


def _keep_out(rule: CheckKeepOut, scene: CheckScene, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    floor = float(rule.place.origin_m[2])
    owner = by_name.get(rule.place.owner)
    exempt = {rule.place.owner} | (set() if owner is None else _owners_of(owner, by_name))
    inner = rule.polygon.buffer(-TOLERANCE_M, join_style="mitre")
    for item in scene.objects:
        if item.name in exempt:
            continue
        entered = [
            part
            for prism in item.prisms
            if _overlap((prism.low_m - floor, prism.high_m - floor), (0.0, rule.height_m))
            and (part := Polygon(_to_place(prism.outline_m, rule.place)).intersection(inner)).area > TOLERANCE_M**2
        ]
        if entered:
            depth = max(shapely.maximum_inscribed_circle(_largest(part)).length for part in entered)
            yield Violation("keep_out", (item.name,), float(depth), 0.0, "m", rule.label)


def _reach(reach: CheckReach, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    for name in reach.objects:
        distance = float(np.hypot(*(by_name[name].origin_m[:2] - reach.base_m[:2])))
        if distance > reach.most_m + TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.most_m)
        elif distance < reach.least_m - TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.least_m)


# Measures.


def _to_place(points_W: FloatArray, place: CheckPlace) -> FloatArray:
    """Points (n, 2) of W in A."""
    cos, sin = np.cos(place.yaw_rad), np.sin(place.yaw_rad)
    return (points_W - place.origin_m[:2]) @ np.array([[cos, -sin], [sin, cos]])


def _outside(outline: FloatArray, polygon: Polygon) -> float:
    """How far a convex outline sticks out of a polygon, 0 within the tolerance: the farthest corner, or the radius of
    the largest circle over a hole."""
    shape = Polygon(outline)
    if polygon.covers(shape) or polygon.buffer(TOLERANCE_M, join_style="mitre").covers(shape):
        return 0.0
    beyond = shape.difference(polygon)
    corners = float(shapely.distance(shapely.points(outline), polygon).max())
    return max(corners, float(shapely.maximum_inscribed_circle(_largest(beyond)).length), TOLERANCE_M)


def _largest(shape: shapely.Geometry) -> Polygon:
    """The largest polygon of what an intersection or a difference left."""
    return max((part for part in shapely.get_parts(shape).tolist() if isinstance(part, Polygon)), key=lambda p: p.area)


def _separation(one: FloatArray, two: FloatArray) -> float:
    """Largest gap between two convex outlines along any edge normal; negative: minus the depth (separating axes)."""
    return max(_gap_along_normals(one, two), _gap_along_normals(two, one))


def _gap_along_normals(one: FloatArray, two: FloatArray) -> float:
    edges = np.roll(one, -1, axis=0) - one
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    lengths = np.hypot(normals[:, 0], normals[:, 1])
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    return float(((two @ normals.T).min(axis=0) - (one @ normals.T).max(axis=0)).max())


def _overlap(one: tuple[float, float], two: tuple[float, float]) -> bool:
    return min(one[1], two[1]) - max(one[0], two[0]) > TOLERANCE_M


def _polygons(outlines: list[FloatArray]) -> NDArray[np.object_]:
    rings = [np.vstack([outline, outline[:1]]) for outline in outlines]
    index = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    return np.asarray(shapely.polygons(shapely.linearrings(np.concatenate(rings), indices=index)))
