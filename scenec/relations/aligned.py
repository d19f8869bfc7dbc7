"""`aligned`: the origins of all members differ by at most `tolerance` (m) across `direction`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations

import numpy as np
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import Motions, box_intervals, sway
from scenec.plan.cases.rectangles import axis_of
from scenec.proofs.constraints import ORIGIN, Difference, LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import (
    AXES,
    WIDEST_M,
    Assignment,
    Batch,
    Frames,
    Mover,
    WeakerNumber,
    WordMeaning,
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

ALIGNED_M = 0.01  # where no tolerance is written


class Aligned(WordMeaning):
    """See the module."""

    kind = "aligned"
    page = (("aligned", "[a, b, ...]", "the origins lie on one line along `axis`, within `tolerance` (0.01)"),)
    frame_dependent = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        members = tuple(thing for side in sides for thing in side)
        frame, direction = frames.along(AXES[written.axis], members)
        tolerance = ALIGNED_M if written.tolerance is None else written.tolerance
        yield SceneRelation(
            "aligned", members, direction, tolerance=tolerance, frame=frame, path=frames.path, word=word.word
        )

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        dx, dy = measures.direction_B(rule, assignment)
        across = [-dy * x + dx * y for x, y in measures.origins_B(rule.things, assignment)]
        return max(across) - min(across) - rule.tolerance

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry:
        points = measures.mates_P(rule, mover.name, mover.owner, assignment)
        px, py = turned_direction(measures.direction_B(rule, assignment), -mover.owner.yaw_rad)
        across = [-py * x + px * y for x, y in points]
        low, high = max(across) - rule.tolerance, min(across) + rule.tolerance
        return strip(-py, px, low, high, mover.around) if high - low >= -SLACK_M else NOWHERE

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        dx, dy = rule.direction
        across = np.stack([-dy * o[..., 0] + dx * o[..., 1] for o in batch.origins_m])
        return across.max(axis=0) - across.min(axis=0) <= rule.tolerance + SLACK

    @override
    def clip_axes(self, rule: SceneRelation) -> slice:
        """Only that across, for a direction along an axis."""
        along = axis_of(rule.direction)
        return slice(None) if along is None else slice(1 - along, 2 - along)

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        dx, dy = rule.direction
        if (boxes := motions.origin_box_m) is not None:
            low, high = box_intervals(boxes, -dy, dx)
            return high.max(axis=1) - low.min(axis=1) <= rule.tolerance
        at = motions.origins_m
        across = -dy * at[..., 0] + dx * at[..., 1]
        most = np.max(motions.origin_shifts_m, axis=0)
        middle = at.mean(axis=1, keepdims=True)
        span = 2.0 * (np.hypot(*np.moveaxis(at - middle, -1, 0)).max(axis=1) + most)
        return np.ptp(across, axis=1) + 2.0 * most + sway(motions.axes_turn_rad) * span <= rule.tolerance

    @override
    def difference_axes(self, rule: SceneRelation, along: FloatArray) -> tuple[FloatArray, ...]:
        return (np.array([-along[1], along[0]]),)

    @override
    def differences(self, rule: SceneRelation, along: FloatArray | None, axis: FloatArray) -> Iterator[Difference]:
        if along is not None and abs(float(along @ axis)) < 1e-6:
            for one, two in permutations(range(len(rule.things)), 2):
                yield Difference(one, ORIGIN, two, ORIGIN, -rule.tolerance)

    @override
    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        if along is not None:
            across = (-float(along[1]), float(along[0]))
            for one, two in permutations(at, 2):
                yield LinearConstraint(one, two, across, rule.tolerance + OUTLINE_SLACK_M)

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        yield WeakerNumber("tolerance", rule.tolerance, rule.tolerance + WIDEST_M, with_tolerance)


RELATION = Aligned()
