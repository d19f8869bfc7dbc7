"""Judge variants by their poses alone: distances of each inserted object from all that moves or is fixed.

Shares nothing with the code that chose the poses: no envelope, no capsules, no feasible regions. The recording is
replayed densely (`replay.verification.dense`), and exact distances between convex shapes decide
(`replay.verification.separation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from replay.recording.episode import Episode
from replay.verification.dense import SUB_TIMES, dense_motion
from replay.verification.inserted_bodies import InsertedBody
from replay.verification.nearest import StaticShape, least_distance, moving_shape, static_shape
from replay.verification.separation import distance_shape, separation_m
from schemas.replay.documents import Near

UNDERNEATH_M = 1e-3  # A shape whose top is no higher than this over the lowest point of an object lies under it.


@dataclass(frozen=True)
class _Placed:
    """An inserted object with its shapes at their poses."""

    name: str
    shapes: tuple[StaticShape, ...]
    lowest_m: float


def near_pairs(
    episode: Episode, variants: Sequence[Sequence[InsertedBody]], clearance_m: float, sub_times: int = SUB_TIMES
) -> list[list[Near]]:
    """For each variant, pairs of an inserted object and something else, with their least distance.

    Every pair that comes nearer than `clearance_m` is there, and the nearest pair of all; distances are never more than
    the true ones.
    """
    placed = [[_placed(body) for body in variant] for variant in variants]
    pairs_by_variant = [_still_pairs(episode, objects) for objects in placed]
    for stretch in dense_motion(episode, sub_times):
        for body in stretch.bodies:
            for shape in body.shapes:
                moving = moving_shape(distance_shape(shape), body.X_WB)
                for objects, near in zip(placed, pairs_by_variant, strict=True):
                    for item in objects:
                        for static in item.shapes:
                            best = min((pair.distance_m for pair in near.values()), default=float("inf"))
                            known = near.get((item.name, body.name))
                            at_most = max(best, clearance_m)
                            if known and known.distance_m < clearance_m:
                                at_most = known.distance_m
                            distance, row = least_distance(moving, static, at_most)
                            if row >= 0:
                                pair = (item.name, body.name)
                                t_s = float(stretch.t_s[row])
                                near[pair] = Near(inserted=pair[0], other=pair[1], distance_m=distance, t_s=t_s)
    rows = [sorted(near.values(), key=lambda pair: pair.distance_m) for near in pairs_by_variant]
    return [[pair for k, pair in enumerate(row) if k == 0 or pair.distance_m < clearance_m] for row in rows]


def _placed(inserted: InsertedBody) -> _Placed:
    shapes = tuple(static_shape(distance_shape(shape), inserted.X_WA) for shape in inserted.body.shapes)
    lowest = min(float(shape.low_W[2]) for shape in shapes)
    return _Placed(inserted.stated.name, shapes, lowest)


def _still_pairs(episode: Episode, objects: Sequence[_Placed]) -> dict[tuple[str, str], Near]:
    """Least distances between inserted objects, and from each to fixtures, except those under it.

    Which fixtures lie under it is decided by height, since several may have a shape of one name.
    """
    fixed = [
        (name, static_shape(distance_shape(shape), fixture.X_WB))
        for fixture in episode.fixtures
        for name, shape in zip(fixture.shape_names, fixture.shapes, strict=True)
    ]
    pairs = {}
    for number, item in enumerate(objects):
        others = [(o.name, s) for o in objects[number + 1 :] for s in o.shapes]
        others += [(name, s) for name, s in fixed if s.high_W[2] > item.lowest_m + UNDERNEATH_M]
        for name, other in others:
            distance = min(
                separation_m(s.distance_shape, s.X_WA, other.distance_shape, other.X_WA) for s in item.shapes
            )
            known = pairs.get((item.name, name))
            if known is None or distance < known.distance_m:
                pairs[item.name, name] = Near(inserted=item.name, other=name, distance_m=distance)
    return pairs
