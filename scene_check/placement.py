"""Violations of one object at its place: pose, support, free height, entry into the geometry of its owners."""

from __future__ import annotations

from collections.abc import Iterator

from scene_check.measures import farthest_outside, overlap, separation, to_place
from scene_check.model import TOLERANCE_M, TURN, CheckObject, Violation
from schemas.scene.geometry import Domain, FixedPose


def wrong_pose(item: CheckObject) -> Iterator[Violation]:
    """Violations of the object's stance, fixed pose or ranges."""
    x, y = to_place(item.origin_m[None, :2], item.place)[0]
    z, yaw = item.origin_m[2] - item.place.origin_m[2], item.yaw_rad - item.place.yaw_rad
    domain = item.domain
    stances = [pose.stance for pose in domain.fixed_poses] or domain.orientation_indices
    stance = item.stance if item.is_known else -1
    if stance not in stances:
        yield Violation("stance", (item.name,), stance, stances[0], "", "stance")
    if domain.fixed_poses:
        off = min(
            max(abs(x - pose.x_m), abs(y - pose.y_m), abs(z - pose.z_m), _turn(yaw, pose.yaw_rad, pose.yaw_rad))
            for pose in _poses_of_stance(domain, item.stance)
        )
        if off > TOLERANCE_M:
            yield Violation("spot", (item.name,), off, 0.0, "m", "spot")
        return
    for axis, value, (low, high) in (("x", x, domain.x_m), ("y", y, domain.y_m)):
        if not low - TOLERANCE_M <= value <= high + TOLERANCE_M:
            yield Violation("range", (item.name,), float(value), low if value < low else high, "m", axis)
    if _turn(yaw, *domain.yaw_rad) > TOLERANCE_M:
        yield Violation("range", (item.name,), float(yaw), domain.yaw_rad[0], "rad", "yaw")


def _poses_of_stance(domain: Domain, stance: int) -> list[FixedPose]:
    """The fixed poses of a domain in one resting orientation; all, where none is in it."""
    return [pose for pose in domain.fixed_poses if pose.stance == stance] or list(domain.fixed_poses)


def _turn(angle: float, low: float, high: float) -> float:
    """How far an angle lies outside [low, high], modulo full turns."""
    past = (angle - low) % TURN
    return max(0.0, min(past - (high - low), TURN - past))


def unsupported(item: CheckObject) -> Iterator[Violation]:
    """Violations of support: too high for its place, below the floor, above a surface, or not wholly on the polygon."""
    place = item.place
    low, high = item.low_m - place.origin_m[2], item.high_m - place.origin_m[2]
    if high > place.geometry.height_m + TOLERANCE_M:
        yield Violation("headroom", (item.name, place.owner), float(high), place.geometry.height_m)
    if low < -TOLERANCE_M and not item.domain.fixed_poses:
        yield Violation("owner_entered", (item.name, place.owner), float(-low), 0.0)
    if not place.geometry.is_volume and not (item.domain.fixed_poses and abs(low) > TOLERANCE_M):
        out = farthest_outside([to_place(prism.outline_m, place) for prism in item.prisms], place.geometry.polygon)
        if out > 0.0:
            yield Violation("off_support", (item.name, place.owner), out, 0.0)
    if low > TOLERANCE_M and not item.domain.fixed_poses and not place.geometry.layers:
        yield Violation("unsupported", (item.name, place.owner), float(low), 0.0)


def owners_entered(item: CheckObject, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Entries into the geometry of owners: parts above the place, walls of volumes, shelves above."""
    place, direct = item.place, True
    while True:
        floor = float(place.origin_m[2])
        top = item.high_m - floor
        if not direct and not place.geometry.layers and top > place.geometry.height_m + TOLERANCE_M:
            yield Violation("headroom", (item.name, place.owner), top, place.geometry.height_m)
        judged = item.prisms if place.geometry.layers or place.geometry.above else ()
        outlines = [to_place(prism.outline_m, place) for prism in judged]
        spans = [(prism.low_m - floor, prism.high_m - floor) for prism in judged]
        standing = list(zip(outlines, spans, strict=True))
        out = max(
            (
                farthest_outside([outline for outline, span in standing if overlap(span, (low, high))], polygon)
                for low, high, polygon in place.geometry.layers
            ),
            default=0.0,
        )
        if out > 0.0:
            yield Violation("outside_volume", (item.name, place.owner), out, 0.0)
        depth = max(
            (
                -separation(outline, part.outline_m)
                for outline, span in standing
                for part in place.geometry.above
                if overlap(span, (part.low_m, part.high_m))
            ),
            default=0.0,
        )
        if depth > TOLERANCE_M:
            yield Violation("owner_entered", (item.name, place.owner), depth, 0.0)
        if place.owner not in by_name:
            return
        place, direct = by_name[place.owner].place, False
