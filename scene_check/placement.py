"""Violations of one object at its place: pose, support, free height, entry into the geometry of its owners."""

from __future__ import annotations

from collections.abc import Iterator

from scene_check.measures import farthest_outside, overlap, separation, to_place
from scene_check.model import TOLERANCE_M, TURN, CheckObject, Violation


def wrong_pose(item: CheckObject) -> Iterator[Violation]:
    """Violations of the object's stance, fixed pose or ranges."""
    x, y = to_place(item.origin_m[None, :2], item.place)[0]
    z, yaw = item.origin_m[2] - item.place.origin_m[2], item.yaw_rad - item.place.yaw_rad
    if item.stance not in item.stances:
        yield Violation("stance", (item.name,), item.stance, item.stances[0], "", "stance")
    if item.fixed_poses:
        off = min(max(abs(x - sx), abs(y - sy), abs(z - sz), _turn(yaw, sa, sa)) for sx, sy, sz, sa in item.fixed_poses)
        if off > TOLERANCE_M:
            yield Violation("spot", (item.name,), off, 0.0, "m", "spot")
        return
    for axis, value, (low, high) in (("x", x, item.x_m), ("y", y, item.y_m)):
        if not low - TOLERANCE_M <= value <= high + TOLERANCE_M:
            yield Violation("range", (item.name,), float(value), low if value < low else high, "m", axis)
    if _turn(yaw, *item.yaw_range_rad) > TOLERANCE_M:
        yield Violation("range", (item.name,), float(yaw), item.yaw_range_rad[0], "rad", "yaw")


def _turn(angle: float, low: float, high: float) -> float:
    """How far an angle lies outside [low, high], modulo full turns."""
    past = (angle - low) % TURN
    return max(0.0, min(past - (high - low), TURN - past))


def unsupported(item: CheckObject) -> Iterator[Violation]:
    """Violations of support: too high for its place, below the floor, above a surface, or not wholly on the polygon."""
    place = item.place
    low, high = item.low_m - place.origin_m[2], item.high_m - place.origin_m[2]
    if high > place.height_m + TOLERANCE_M:
        yield Violation("headroom", (item.name, place.owner), float(high), place.height_m)
    if low < -TOLERANCE_M and not item.fixed_poses:
        yield Violation("owner_entered", (item.name, place.owner), float(-low), 0.0)
    if place.polygon is not None and not (item.fixed_poses and abs(low) > TOLERANCE_M):
        out = farthest_outside([to_place(prism.outline_m, place) for prism in item.prisms], place.polygon)
        if out > 0.0:
            yield Violation("off_support", (item.name, place.owner), out, 0.0)
    if low > TOLERANCE_M and not item.fixed_poses and not place.layers:
        yield Violation("unsupported", (item.name, place.owner), float(low), 0.0)


def owners_entered(item: CheckObject, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Entries into the geometry of owners: parts above the place, walls of volumes, shelves above."""
    place, direct = item.place, True
    while True:
        floor = float(place.origin_m[2])
        top = item.high_m - floor
        if not direct and not place.layers and top > place.height_m + TOLERANCE_M:
            yield Violation("headroom", (item.name, place.owner), top, place.height_m)
        judged = item.prisms if place.layers or place.above else ()
        outlines = [to_place(prism.outline_m, place) for prism in judged]
        spans = [(prism.low_m - floor, prism.high_m - floor) for prism in judged]
        standing = list(zip(outlines, spans, strict=True))
        out = max(
            (
                farthest_outside([outline for outline, span in standing if overlap(span, (low, high))], polygon)
                for low, high, polygon in place.layers
            ),
            default=0.0,
        )
        if out > 0.0:
            yield Violation("outside_volume", (item.name, place.owner), out, 0.0)
        depth = max(
            (
                -separation(outline, part.outline_m)
                for outline, span in standing
                for part in place.above
                if overlap(span, (part.low_m, part.high_m))
            ),
            default=0.0,
        )
        if depth > TOLERANCE_M:
            yield Violation("owner_entered", (item.name, place.owner), depth, 0.0)
        if place.owner not in by_name:
            return
        place, direct = by_name[place.owner].place, False
