"""`surrounding`: seen from the origin of the first, the origins of the others lie all around.

The angles between neighbours, which add up to a whole turn, lie within `angle_rad`: (least, largest). `evenly` means
equal angles within a tolerance. A `distance` of each to the centre is a relation of its own (`near`, `far_from`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from math import atan2, ceil, degrees, hypot, pi, radians

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.ir.problem import Problem, Proof
from scenec.plan.cases.motions import ROUNDING, Motions
from scenec.proofs.constraints import LinearConstraint
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import (
    Assignment,
    Batch,
    Frames,
    Mover,
    WeakerNumber,
    WordMeaning,
    distance_relations,
)
from scenec.solve import measures
from scenec.solve.measures import SLACK
from scenec.solve.region_geometry import NOWHERE, wedge
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

EVENLY_RAD = radians(10.0)  # where no tolerance is written
TURN = 2.0 * pi
CENTRE_M = 1e-4  # an origin closer to the centre has no direction from there
WIDEST_PIECE_RAD = 1.0  # regions of wider angles are put together
ANGLE_STEP_DEG = 0.1  # raster of suggested angles
NORMALS = 8  # in which proofs look for a member
FAR_SLACK_M = 10.0 * OUTLINE_SLACK_M  # an angle that the judge tolerates, at some metres

Arc = tuple[float, float]  # from, to; counter-clockwise


class Surrounding(WordMeaning):
    """See the module."""

    kind = "surrounding"
    page = (
        (
            "surrounding",
            "[centre, a, b, ...]",
            "the angles between neighbours, from the origin of the centre to theirs, are equal (`evenly`, within "
            "`tolerance` rad, 10 degrees) or at least `least_angle`; `distance`: of each to the centre, as for near",
        ),
    )
    constrains_early = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        members = tuple(thing for side in sides[1:] for thing in side)
        angle, key = _written_angle(written, len(members))
        for centre in sides[0]:
            things = (centre, *members)
            yield SceneRelation("surrounding", things, path=frames.path, word=word.word, angle_rad=angle, key=key)
            yield from distance_relations(written, ((centre, name) for name in members), frames.path, word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        (cx, cy), *others = measures.origins_B(rule.things, assignment)
        if min(hypot(x - cx, y - cy) for x, y in others) < CENTRE_M:
            return pi
        least, most = _angle(rule)
        headings = sorted(atan2(y - cy, x - cx) for x, y in others)
        angles = [b - a for a, b in zip(headings, [*headings[1:], headings[0] + TURN], strict=True)]
        return max(least - min(angles), max(angles) - most)

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry | None:
        """Wedges about the centre; None for the centre itself and before it is placed."""
        if rule.things[0] == mover.name or rule.things[0] not in assignment:
            return None
        cx, cy = mover.owner.inverse_point(*measures.origin_B(assignment[rule.things[0]], assignment))
        mates = [name for name in rule.things[1:] if name != mover.name and name in assignment]
        points = [mover.owner.inverse_point(*point) for point in measures.origins_B(mates, assignment)]
        arcs: list[Arc] = [(0.0, TURN)]
        for x, y in points:
            heading = atan2(y - cy, x - cx)
            arcs = _common(arcs, [(heading + a, heading + b) for a, b in _arcs(rule)])
        size = sum(map(abs, mover.around)) + abs(cx) + abs(cy) + 1.0
        wedges = [wedge((cx, cy), middle, half, size) for middle, half in _pieces(arcs)]
        return shapely.union_all(wedges) if wedges else NOWHERE

    @override
    def placed_last(self, rule: SceneRelation) -> tuple[str, ...]:
        return rule.things[1:]

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """Any two members are so far apart as the numbers of angles between them allow."""
        everywhere = np.ones(batch.origins_m[0].shape[:-1], dtype=bool)
        if batch.numbers[0] != 0:
            return everywhere
        steps = [origin - batch.origins_m[0] for origin in batch.origins_m[1:]]
        good = everywhere
        for step in steps:
            good &= np.hypot(step[..., 0], step[..., 1]) > CENTRE_M
        headings = [np.arctan2(step[..., 1], step[..., 0]) for step in steps]
        for one, two in combinations(headings, 2):
            ahead = (two - one) % TURN
            good &= np.any([(ahead >= a - SLACK) & (ahead <= b + SLACK) for a, b in _arcs(rule)], axis=0)
        return good

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """Unused: `holds_throughout` measures the angles."""
        return np.zeros(len(motions.axes_turn_rad))

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        """The heading of each member changes by at most asin(motion / distance), that of the centre included.

        If all headings change by at most s, the least angle between neighbours falls by at most 2 s and the largest
        rises by at most 2 s: a free arc of the new ones, shrunk by s at both ends, was free before.
        """
        at, shifts = motions.origins_m, motions.origin_shifts_m
        steps = at[:, 1:] - at[:, :1]
        length = np.hypot(steps[..., 0], steps[..., 1])
        moved = np.stack(shifts[1:], axis=1) + shifts[0][:, None]
        swing = np.arcsin(np.clip(moved / np.maximum(length, 1e-9), 0.0, 1.0)).max(axis=1)
        headings = np.sort(np.arctan2(steps[..., 1], steps[..., 0]), axis=1)
        angles = np.diff(headings, axis=1, append=headings[:, :1] + TURN)
        least, most = _angle(rule)
        is_clear = (moved + CENTRE_M < length).all(axis=1)
        is_wide = angles.min(axis=1) - 2.0 * swing - ROUNDING >= least
        return is_clear & is_wide & (angles.max(axis=1) + 2.0 * swing + ROUNDING <= most)

    @override
    def refuted(self, rule: SceneRelation, problem: Problem) -> Proof | None:
        """The angles between neighbours add up to a whole turn."""
        count, (least, _) = len(rule.things) - 1, _angle(rule)
        needed = degrees(count * least)
        if count * least <= TURN + OUTLINE_SLACK_M:
            return None
        text = f"{count} angles of {degrees(least):.4g} degrees about {rule.things[0]} are more than a whole turn"
        return Proof("empty-domain", text, needed, 360.0, "deg", (rule.path,))

    @override
    def disjunctions(
        self, rule: SceneRelation, at: Sequence[int]
    ) -> Iterator[tuple[tuple[LinearConstraint, ...], ...]]:
        """If no angle is wider than a half turn, some member lies ahead of the centre in every direction."""
        least, most = _angle(rule)
        count = len(at) - 1
        if min(most, TURN - (count - 1) * least) > pi:
            return
        for angle in np.arange(NORMALS) * (TURN / NORMALS):
            back = (-float(np.cos(angle)), -float(np.sin(angle)))
            yield tuple((LinearConstraint(at[0], other, back, FAR_SLACK_M),) for other in at[1:])

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        least, most = _angle(rule)
        to_key = degrees if rule.key.endswith("_deg") else float
        from_key = radians if rule.key.endswith("_deg") else float
        step = ANGLE_STEP_DEG if rule.key.endswith("_deg") else radians(ANGLE_STEP_DEG)
        if most < TURN:
            even = TURN / (len(rule.things) - 1)
            yield WeakerNumber(
                rule.key,
                to_key(most - even),
                to_key(pi),
                lambda r, v: replace(r, angle_rad=_even(len(r.things) - 1, from_key(v))),
                step,
                from_key(1.0),
            )
        else:
            yield WeakerNumber(
                rule.key,
                to_key(least),
                step,
                lambda r, v: replace(r, angle_rad=(from_key(v), TURN)),
                step,
                from_key(1.0),
            )


def _written_angle(written: Relation, count: int) -> tuple[Arc, str]:
    """Least and largest angle between `count` neighbours, and the key that says it."""
    if written.evenly:
        if written.tolerance is not None:
            return _even(count, written.tolerance), "tolerance"
        tolerance = EVENLY_RAD if written.tolerance_deg is None else radians(written.tolerance_deg)
        return _even(count, tolerance), "tolerance_deg"
    if written.least_angle is not None:
        return (written.least_angle, TURN), "least_angle"
    return (radians(written.least_angle_deg or 0.0), TURN), "least_angle_deg"


def _even(count: int, tolerance_rad: float) -> Arc:
    return max(TURN / count - tolerance_rad, 0.0), min(TURN / count + tolerance_rad, TURN - 1e-9)


def _angle(rule: SceneRelation) -> Arc:
    return rule.angle_rad or (0.0, TURN)


def _arcs(rule: SceneRelation) -> list[Arc]:
    """Where one member may lie ahead of another: 1 to n - 1 angles ahead, and the rest of the turn behind."""
    count, (least, most) = len(rule.things) - 1, _angle(rule)
    arcs = []
    for steps in range(1, count):
        low = max(steps * least, TURN - (count - steps) * most)
        high = min(steps * most, TURN - (count - steps) * least)
        if high >= low - SLACK:
            arcs.append((low, max(low, high)))
    return arcs


def _common(some: Sequence[Arc], others: Sequence[Arc]) -> list[Arc]:
    """The intersection of two sets of arcs; the first within (0, 2 pi)."""
    common = []
    for low, high in some:
        for begin, end in others:
            turns = TURN * np.floor((begin - low) / TURN)
            for shift in (turns, turns + TURN):
                a, b = max(low, begin - shift), min(high, end - shift)
                if b >= a - SLACK:
                    common.append((a, max(a, b)))
    return common


def _pieces(arcs: Sequence[Arc]) -> Iterator[tuple[float, float]]:
    """Arcs as (middle, half width) of narrow ones."""
    for low, high in arcs:
        count = max(1, ceil((high - low) / (2.0 * WIDEST_PIECE_RAD)))
        width = (high - low) / count
        yield from ((low + (k + 0.5) * width, 0.5 * width) for k in range(count))


RELATION = Surrounding()
