"""`in_line`: the origins follow one another along `direction` and differ by at most `tolerance` (m) across it.

With a spacing (`gap_m` above 0), each step along the direction is that, within the tolerance; without, it is not
negative.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, permutations

import numpy as np
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import Motions, box_intervals, sway
from scenec.proofs.constraints import ORIGIN, Difference, LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import (
    AXES,
    SUGGESTION_STEP_M,
    WIDEST_M,
    Assignment,
    Batch,
    Frames,
    Mover,
    WeakerNumber,
    WordMeaning,
    along_axis,
    with_gap,
    with_tolerance,
)
from scenec.solve import measures
from scenec.solve.frames import turned_direction
from scenec.solve.measures import SLACK
from scenec.solve.planar import SLACK_M
from scenec.solve.region_geometry import NOWHERE, strip
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

IN_LINE_M = 0.01  # where no tolerance is written


class InLine(WordMeaning):
    """See the module."""

    kind = "in_line"
    page = (
        (
            "in_line",
            "[a, b, ...]",
            "the origins follow one another along `axis`, on one line within `tolerance` (0.01); with `spacing`, each "
            "step is that, within the tolerance",
        ),
    )
    frame_dependent = True
    constrains_early = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        members = tuple(thing for side in sides for thing in side)
        frame, direction = frames.along(AXES[written.axis], members)
        tolerance = IN_LINE_M if written.tolerance is None else written.tolerance
        spacing = written.spacing or 0.0
        yield SceneRelation("in_line", members, direction, spacing, tolerance, frame, frames.path, word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        dx, dy = measures.direction_B(rule, assignment)
        points = measures.origins_B(rule.things, assignment)
        along, across = [dx * x + dy * y for x, y in points], [-dy * x + dx * y for x, y in points]
        low, high = _steps(rule, 1)
        off = max(max(low - (b - a), b - a - high) for a, b in pairwise(along))
        return max(max(across) - min(across) - rule.tolerance, off)

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry:
        mates = _mates(rule, mover, assignment)
        px, py = turned_direction(measures.direction_B(rule, assignment), -mover.owner.yaw_rad)
        number = rule.things.index(mover.name)
        across = [-py * x + px * y for x, y in mates.values()]
        size = 1.0 + sum(map(abs, mover.around)) + max(abs(x) + abs(y) for x, y in mates.values())
        begin, end = -size, size
        for other, (x, y) in mates.items():
            low, high = _steps(rule, abs(number - other))
            at = px * x + py * y
            nearest, farthest = (at + low, at + high) if other < number else (at - high, at - low)
            begin, end = max(begin, nearest), min(end, farthest)
        low, high = max(across) - rule.tolerance, min(across) + rule.tolerance
        if high - low < -SLACK_M or end - begin < -SLACK_M:
            return NOWHERE
        return strip(px, py, begin, end, mover.around).intersection(strip(-py, px, low, high, mover.around))

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        dx, dy = rule.direction
        along = [dx * o[..., 0] + dy * o[..., 1] for o in batch.origins_m]
        across = np.stack([-dy * o[..., 0] + dx * o[..., 1] for o in batch.origins_m])
        good = across.max(axis=0) - across.min(axis=0) <= rule.tolerance + SLACK
        for (m, one), (n, two) in pairwise(zip(batch.numbers, along, strict=True)):
            low, high = _steps(rule, n - m)
            good &= (two - one >= low - SLACK) & (two - one <= high + SLACK)
        return good

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        """Along and across the direction each origin stays in an interval; those of two members differ by the ends."""
        dx, dy = rule.direction
        least, most = _steps(rule, 1)
        if (boxes := motions.origin_box_m) is not None:
            begin, end = box_intervals(boxes, dx, dy)
            low, high = box_intervals(boxes, -dy, dx)
            lean = np.zeros(len(begin))
        else:
            at, shift = motions.origins_m, np.stack(motions.origin_shifts_m, axis=1)
            along, across = dx * at[..., 0] + dy * at[..., 1], -dy * at[..., 0] + dx * at[..., 1]
            begin, end, low, high = along - shift, along + shift, across - shift, across + shift
            reach = np.hypot(*np.moveaxis(at - at.mean(axis=1, keepdims=True), -1, 0)) + shift
            lean = sway(motions.axes_turn_rad) * 2.0 * reach.max(axis=1)
        aside = high.max(axis=1) - low.min(axis=1) + lean
        shortest, longest = begin[:, 1:] - end[:, :-1], end[:, 1:] - begin[:, :-1]
        stays = (shortest.min(axis=1) - lean >= least) & (longest.max(axis=1) + lean <= most)
        return stays & (aside <= rule.tolerance)

    @override
    def difference_axes(self, rule: SceneRelation, along: FloatArray) -> tuple[FloatArray, ...]:
        return along, np.array([-along[1], along[0]])

    @override
    def differences(self, rule: SceneRelation, along: FloatArray | None, axis: FloatArray) -> Iterator[Difference]:
        if along is None:
            return
        cosine = float(along @ axis)
        if along_axis(cosine):
            low, high = _steps(rule, 1)
            for one, two in pairwise(range(len(rule.things)) if cosine > 0.0 else range(len(rule.things))[::-1]):
                yield Difference(one, ORIGIN, two, ORIGIN, low)
                yield Difference(two, ORIGIN, one, ORIGIN, -high)
        elif abs(cosine) < 1e-6:
            for one, two in permutations(range(len(rule.things)), 2):
                yield Difference(one, ORIGIN, two, ORIGIN, -rule.tolerance)

    @override
    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        if along is None:
            return
        x, y = float(along[0]), float(along[1])
        low, high = _steps(rule, 1)
        for one, two in pairwise(at):
            yield LinearConstraint(one, two, (-x, -y), OUTLINE_SLACK_M - low)
            if high < np.inf:
                yield LinearConstraint(one, two, (x, y), OUTLINE_SLACK_M + high)
        for one, two in permutations(at, 2):
            yield LinearConstraint(one, two, (-y, x), rule.tolerance + OUTLINE_SLACK_M)

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        yield WeakerNumber("tolerance", rule.tolerance, rule.tolerance + WIDEST_M, with_tolerance)
        if rule.gap_m > 0.0:
            yield WeakerNumber("spacing", rule.gap_m, SUGGESTION_STEP_M, with_gap)
            yield WeakerNumber("spacing", rule.gap_m, rule.gap_m + WIDEST_M, with_gap)


def _steps(rule: SceneRelation, count: int) -> tuple[float, float]:
    """Least and largest difference along the direction of two members with so many steps from one to the other."""
    if rule.gap_m > 0.0:
        return count * (rule.gap_m - rule.tolerance), count * (rule.gap_m + rule.tolerance)
    return 0.0, np.inf


def _mates(rule: SceneRelation, mover: Mover, assignment: Assignment) -> Mapping[int, tuple[float, float]]:
    """Origins in P of the members that are placed, by their number."""
    return {
        number: mover.owner.inverse_point(*measures.origin_B(assignment[name], assignment))
        for number, name in enumerate(rule.things)
        if name != mover.name and name in assignment
    }


RELATION = InLine()
