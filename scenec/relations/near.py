"""`near`: the distance of the footprints is at most `gap_m`; where that is 0, they overlap."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import Motions, footprint_distances, overlap_depths
from scenec.plan.cases.rectangles import distance
from scenec.proofs.constraints import BEGIN, END, Difference, LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M, TURN, support_bounds
from scenec.relations.protocol import (
    WIDEST_M,
    Assignment,
    Batch,
    Frames,
    Mover,
    WeakerNumber,
    WordMeaning,
    distance_relations,
    with_gap,
)
from scenec.solve import measures
from scenec.solve.measures import SLACK
from scenec.solve.planar import SEGMENTS
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

DISTANCE_NORMALS = 16  # in which the origins are bounded by proofs


class Near(WordMeaning):
    """See the module."""

    kind = "near"
    page = (("near", "[a, b]", "the distance of the footprints is at most `distance`; within a range of two"),)
    slow_to_measure = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        pairs = ((one, two) for one, two in product(*sides))
        yield from distance_relations(written, pairs, frames.path, word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        one, two = (assignment[name] for name in rule.things)
        return measures.distance(one, two, assignment) - rule.gap_m

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry:
        no_fit = measures.no_fit_of_mate(rule, mover.name, mover.turned, mover.owner, assignment)
        return shapely.union_all(shapely.buffer(no_fit, rule.gap_m, quad_segs=4 * SEGMENTS))

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """The distance of rectangles is a lower bound of that of footprints."""
        return distance(*batch.rects_m) <= rule.gap_m + SLACK

    @override
    def most_distance_m(self, rule: SceneRelation) -> float:
        return rule.gap_m

    @override
    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        return uneven

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """The distance of the footprints, where it can be small enough; below 0 where they must overlap and do."""
        one, two = motions.members
        if rule.gap_m == 0.0:
            return footprint_distances(one, two, 0.0) - overlap_depths(one, two)
        return footprint_distances(one, two, rule.gap_m)

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        one, two = motions.members
        return value + (one.outline_m + two.outline_m + motions.rounding_m) <= rule.gap_m

    @override
    def differences(self, rule: SceneRelation, along: FloatArray | None, axis: FloatArray) -> Iterator[Difference]:
        yield Difference(0, BEGIN, 1, END, -rule.gap_m)
        yield Difference(1, BEGIN, 0, END, -rule.gap_m)

    @override
    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        for angle in np.arange(DISTANCE_NORMALS) * (TURN / DISTANCE_NORMALS):
            normal = np.array([np.cos(angle), np.sin(angle)])
            front = support_bounds(poses[0].outline, normal, poses[0].yaw)[1]
            back = support_bounds(poses[1].outline, normal, poses[1].yaw)[3]
            bound = rule.gap_m + front + back + OUTLINE_SLACK_M
            yield LinearConstraint(at[0], at[1], (float(normal[0]), float(normal[1])), bound)

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        if rule.gap_m > 0.0:
            yield WeakerNumber(rule.key or "distance", rule.gap_m, rule.gap_m + WIDEST_M, with_gap)


RELATION = Near()
