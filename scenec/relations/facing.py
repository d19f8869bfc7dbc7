"""`facing`: +x of the first, or the direction of one of its parts, points at the origin of the second within
`tolerance` (rad). `angle_rad` of the relation is the heading of that part at yaw 0, None for the front."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import atan2, hypot, pi, radians

import numpy as np
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import ROUNDING, Motions
from scenec.plan.cases.rectangles import wrapped_all
from scenec.proofs.constraints import LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import Assignment, Batch, Frames, Mover, WordMeaning
from scenec.solve import measures
from scenec.solve.frames import pose_of
from scenec.solve.measures import SLACK
from scenec.solve.placed import Placed
from scenec.solve.region_geometry import wedge
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

FACING_RAD = radians(10.0)  # where no tolerance is written
NEAREST_M = 1e-5  # origins closer than this define no direction
NEAREST_IN_PLANS_M = 1e-4
WIDEST_WEDGE_RAD = 1.4  # beyond, a wedge would leave too little out


class Facing(WordMeaning):
    """See the module."""

    kind = "facing"
    page = (
        (
            "facing",
            "[a, b], [a.part, b]",
            "the front (+x) of a, or the direction from its origin to a part or affordance (`mug.handle`), points at b "
            "within `tolerance` rad (10 degrees)",
        ),
    )

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        tolerance = FACING_RAD if written.tolerance is None else written.tolerance
        if written.tolerance_deg is not None:
            tolerance = float(np.radians(written.tolerance_deg))
        for chosen in product(*sides):
            part = frames.part_heading_rad(chosen[0])
            angle = None if part is None else (part, part)
            yield SceneRelation(
                "facing", chosen, tolerance=tolerance, path=frames.path, word=word.word, angle_rad=angle
            )

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        (ax, ay), (bx, by) = measures.origins_B(rule.things, assignment)
        if hypot(bx - ax, by - ay) < NEAREST_M:
            return pi
        front = measures.front_B(assignment[rule.things[0]], assignment) + _part_rad(rule)
        return abs(measures.wrapped(atan2(by - ay, bx - ax) - front)) - rule.tolerance

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry | None:
        if rule.tolerance > WIDEST_WEDGE_RAD:
            return None
        (point,) = measures.mates_P(rule, mover.name, mover.owner, assignment)
        ahead, away = mover.turned.yaw_rad + mover.turned.shape.front_rad + _part_rad(rule), pi
        if rule.things[1] == mover.name:
            ahead = measures.front_B(assignment[rule.things[0]], assignment) + _part_rad(rule) - mover.owner.yaw_rad
            away = 0.0
        size = sum(abs(v) for v in mover.around) + sum(abs(v) for v in point) + 1.0
        return wedge(point, ahead + away, rule.tolerance, size)

    @override
    def placed_last(self, rule: SceneRelation) -> tuple[str, ...]:
        return rule.things[:1]

    @override
    def exact_yaw(self, rule: SceneRelation, placed: Placed, assignment: Assignment) -> float | None:
        if rule.things[0] != placed.name:
            return None
        (ax, ay), (bx, by) = measures.origins_B(rule.things, assignment)
        owner = pose_of(placed.parent, assignment)
        return atan2(by - ay, bx - ax) - owner.yaw_rad - placed.turned.shape.front_rad - _part_rad(rule)

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        toward = batch.origins_m[1] - batch.origins_m[0]
        heading = np.arctan2(toward[..., 1], toward[..., 0])
        away = np.abs(wrapped_all(heading - batch.fronts_rad[0] - _part_rad(rule)))
        return (away <= rule.tolerance + SLACK) & (np.hypot(toward[..., 0], toward[..., 1]) > NEAREST_IN_PLANS_M)

    @override
    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        return member == 0

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        """By the law of sines the heading toward the second changes by at most asin(motion / distance)."""
        at, first = motions.origins_m, motions.members[0]
        toward = at[:, 1] - at[:, 0]
        length = np.hypot(*toward.T)
        away = np.abs(wrapped_all(np.arctan2(toward[:, 1], toward[:, 0]) - first.front_rad - _part_rad(rule)))
        moved = sum(motions.origin_shifts_m)
        swing = np.arcsin(np.clip(moved / np.maximum(length, 1e-9), 0.0, 1.0))
        return (away + swing + first.turn_rad + ROUNDING <= rule.tolerance) & (moved < length)

    @override
    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        """The second origin lies in the wedge swept by the front of the first, if that is narrower than pi."""
        w, x, y, z = poses[0].stance.quat_wxyz
        low, high = poses[0].yaw
        front = np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)) + _part_rad(rule)
        half = (high - low) / 2.0 + rule.tolerance + OUTLINE_SLACK_M
        if half >= np.pi / 2.0:
            return
        middle = front + (low + high) / 2.0
        for sign in (1.0, -1.0):
            angle = middle + sign * (half + np.pi / 2.0)
            yield LinearConstraint(at[0], at[1], (float(np.cos(angle)), float(np.sin(angle))), OUTLINE_SLACK_M)

    @override
    def heading_matters(self, rule: SceneRelation, name: str) -> bool:
        return rule.things[0] == name


def _part_rad(rule: SceneRelation) -> float:
    """Heading of the part that is turned toward the second, from the front."""
    return 0.0 if rule.angle_rad is None else rule.angle_rad[0]


RELATION = Facing()
