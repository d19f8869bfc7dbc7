"""`left_of`, `right_of`, `front_of`, `behind`: the footprint of the first ends before that of the second begins.

Lowered with `direction`, a unit vector in the frame of the relation, and `gap_m`, the least distance along it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from shapely import Polygon
from typing_extensions import override

from scenec.plan.cases.motions import Motions, sway
from scenec.plan.cases.rectangles import AxisOrder, axis_of, extent
from scenec.proofs.constraints import BEGIN, END, Difference, LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M, support_bounds
from scenec.relations.protocol import (
    Assignment,
    Batch,
    Frames,
    Mover,
    WeakerNumber,
    WordMeaning,
    along_axis,
    with_gap,
)
from scenec.solve import measures
from scenec.solve.frames import turned_direction
from scenec.solve.measures import SLACK
from scenec.solve.region_geometry import half_plane
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

# By viewpoint: the unit vectors to the right and away from the viewer, in x and y of the frame.
_RIGHT: dict[str, tuple[float, float]] = {
    "front": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "left": (0.0, -1.0),
    "right": (0.0, 1.0),
}
_AWAY: dict[str, tuple[float, float]] = {
    "front": (0.0, 1.0),
    "back": (0.0, -1.0),
    "left": (1.0, 0.0),
    "right": (-1.0, 0.0),
}
_AXIS = {"left_of": _RIGHT, "right_of": _RIGHT, "front_of": _AWAY, "behind": _AWAY}


class Before(WordMeaning):
    """See the module."""

    kind = "before"
    page = (
        ("left_of", "[a, b]", "the whole footprint of a lies at smaller x than that of b, by `gap`"),
        ("right_of", "[a, b]", "likewise at larger x"),
        ("front_of", "[a, b]", "likewise at smaller y"),
        ("behind", "[a, b]", "likewise at larger y"),
    )
    frame_dependent = True
    separable = True
    lifts_to_owners = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        for chosen in product(*sides):
            frame, direction = frames.along(_AXIS[word.word][written.viewpoint], chosen)
            things = chosen[::-1] if word.reverse else chosen
            yield SceneRelation("before", things, direction, written.gap, frame=frame, path=frames.path, word=word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        direction = measures.direction_B(rule, assignment)
        _, end = measures.extent(assignment[rule.things[0]], direction, assignment)
        begin, _ = measures.extent(assignment[rule.things[1]], direction, assignment)
        return end + rule.gap_m - begin

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> Polygon:
        first, second = rule.things
        dx, dy = measures.direction_B(rule, assignment)
        px, py = turned_direction((dx, dy), -mover.owner.yaw_rad)
        start = mover.owner.x_m * dx + mover.owner.y_m * dy
        along = mover.turned.hull @ (px, py)
        begin, end = measures.extent(assignment[second if first == mover.name else first], (dx, dy), assignment)
        if first == mover.name:
            return half_plane(px, py, begin - rule.gap_m - start - float(along.max()), mover.around)
        return half_plane(-px, -py, -(end + rule.gap_m - start - float(along.min())), mover.around)

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """Rectangles in this order imply it for footprints."""
        end = extent(batch.rects_m[0], rule.direction)[1]
        begin = extent(batch.rects_m[1], rule.direction)[0]
        return end + rule.gap_m <= begin + SLACK

    @override
    def kept_by_rectangles(self, rule: SceneRelation) -> bool:
        return axis_of(rule.direction) is not None

    @override
    def axis_order(self, rule: SceneRelation) -> AxisOrder | None:
        """Against an axis the members are reversed."""
        axis = axis_of(rule.direction)
        if axis is None:
            return None
        first, second = (0, 1) if rule.direction[axis] > 0.0 else (1, 0)
        return AxisOrder(first, second, axis, rule.gap_m)

    @override
    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        return uneven

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """The gap before the second begins."""
        ends = [one.hull_along(rule.direction) for one in motions.members]
        return ends[1].min(axis=1) - ends[0].max(axis=1)

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        one, two = motions.members
        moved = one.outline_m + two.outline_m + motions.rounding_m
        span = np.hypot(*(two.at_m - one.at_m).T) + sum(m.radius_m + m.outline_m for m in motions.members)
        return value - (moved + sway(motions.axes_turn_rad) * span) >= rule.gap_m

    @override
    def difference_axes(self, rule: SceneRelation, along: FloatArray) -> tuple[FloatArray, ...]:
        return (along,)

    @override
    def differences(self, rule: SceneRelation, along: FloatArray | None, axis: FloatArray) -> Iterator[Difference]:
        if along is None or not along_axis(cosine := float(along @ axis)):
            return
        first, second = (0, 1) if cosine > 0.0 else (1, 0)
        yield Difference(first, END, second, BEGIN, rule.gap_m)

    @override
    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        if along is None:
            return
        front = support_bounds(poses[0].outline, along, poses[0].yaw)[0]
        back = support_bounds(poses[1].outline, along, poses[1].yaw)[2]
        bound = OUTLINE_SLACK_M - rule.gap_m - front - back
        yield LinearConstraint(at[0], at[1], (-along[0], -along[1]), bound)

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        if rule.gap_m > 0.0:
            yield WeakerNumber("gap", rule.gap_m, 0.0, with_gap)


RELATION = Before()
