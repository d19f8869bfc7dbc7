"""`far_from`: the distance of the footprints is at least `gap_m`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import shapely
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import Motions, footprint_distances
from scenec.plan.cases.rectangles import distance
from scenec.relations.protocol import (
    SUGGESTION_STEP_M,
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
from scenec.solve.planar import ROUND_OUT, SEGMENTS
from scenec.solve.region_geometry import widened
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord


class FarFrom(WordMeaning):
    """See the module. Proofs take it as a pair that must keep `least_distance_m`."""

    kind = "far_from"
    page = (("far_from", "[a, b]", "the distance of the footprints is at least `distance`; within a range of two"),)
    lifts_to_owners = True
    slow_to_measure = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        for one, two in product(*sides):
            if isinstance(written.distance, tuple):
                yield from distance_relations(written, [(one, two)], frames.path, word.word)
            else:
                least_m = written.distance or 0.0
                yield SceneRelation("far_from", (one, two), gap_m=least_m, path=frames.path, word=word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        one, two = (assignment[name] for name in rule.things)
        return rule.gap_m - measures.distance(one, two, assignment)

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry:
        no_fit = measures.no_fit_of_mate(rule, mover.name, mover.turned, mover.owner, assignment)
        grown = shapely.union_all(shapely.buffer(no_fit, rule.gap_m * ROUND_OUT, quad_segs=SEGMENTS))
        return shapely.difference(shapely.box(*widened(mover.around)), grown)

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """The distance of rectangles is a lower bound of that of footprints."""
        return distance(*batch.rects_m) >= rule.gap_m - SLACK

    @override
    def kept_by_rectangles(self, rule: SceneRelation) -> bool:
        return True

    @override
    def least_distance_m(self, rule: SceneRelation) -> float:
        return rule.gap_m

    @override
    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        return uneven

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """The distance of the footprints."""
        one, two = motions.members
        return footprint_distances(one, two)

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        one, two = motions.members
        return value - (one.outline_m + two.outline_m + motions.rounding_m) >= rule.gap_m

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        if rule.gap_m > 0.0:
            yield WeakerNumber(rule.key or "distance", rule.gap_m, SUGGESTION_STEP_M, with_gap)


RELATION = FarFrom()
