"""`between`: the origin of the first lies between those of the two others, within `tolerance` (m) of their line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import hypot

import numpy as np
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.plan.cases.motions import Motions
from scenec.proofs.constraints import LinearConstraint
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import (
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
from scenec.solve.measures import SLACK
from scenec.solve.region_geometry import beside
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord

BETWEEN_M = 0.02  # where no tolerance is written


class Between(WordMeaning):
    """See the module."""

    kind = "between"
    page = (("between", "[a, b, c]", "the origin of a lies between b and c, within `tolerance` (0.02) of their line"),)

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        tolerance = BETWEEN_M if written.tolerance is None else written.tolerance
        for chosen in product(*sides):
            yield SceneRelation("between", chosen, tolerance=tolerance, path=frames.path, word=word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        (px, py), (ax, ay), (bx, by) = measures.origins_B(rule.things, assignment)
        length = max(hypot(bx - ax, by - ay), 1e-12)
        ux, uy = (bx - ax) / length, (by - ay) / length
        along, aside = (px - ax) * ux + (py - ay) * uy, abs((py - ay) * ux - (px - ax) * uy)
        return max(-along, along - length, aside - rule.tolerance)

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry | None:
        if rule.things[0] != mover.name:
            return None
        one, two = measures.mates_P(rule, mover.name, mover.owner, assignment)
        return beside(one, two, rule.tolerance)

    @override
    def placed_last(self, rule: SceneRelation) -> tuple[str, ...]:
        return rule.things[:1]

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        one, two, three = batch.origins_m
        line, step = three - two, one - two
        length = np.maximum(np.hypot(line[..., 0], line[..., 1]), 1e-6)
        along = (step * line).sum(axis=-1) / length
        aside = np.abs(step[..., 0] * line[..., 1] - step[..., 1] * line[..., 0]) / length
        return (along >= 0.0) & (along <= length) & (aside <= rule.tolerance + SLACK)

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        """Uses that the foot of the perpendicular keeps its share of the line, and bounds the rest by the motion of the
        ends."""
        at, shifts = motions.origins_m, motions.origin_shifts_m
        line, step = at[:, 2] - at[:, 1], at[:, 0] - at[:, 1]
        length = np.maximum(np.hypot(*line.T), 1e-9)
        along = (step * line).sum(axis=1) / length
        aside = np.abs(step[:, 0] * line[:, 1] - step[:, 1] * line[:, 0]) / length
        moved = shifts[0] + np.maximum(shifts[1], shifts[2])
        spread = shifts[1] + shifts[2]
        lean = np.clip(spread / np.maximum(length - spread, 1e-9), 0.0, 1.0)
        rest = np.minimum(along, length - along) * np.maximum(1.0 - spread / length, 0.0)
        return (aside + moved <= rule.tolerance) & (rest >= moved + aside * lean)

    @override
    def disjunctions(
        self, rule: SceneRelation, at: Sequence[int]
    ) -> Iterator[tuple[tuple[LinearConstraint, ...], ...]]:
        """The first origin lies in the box of the two others, grown by the tolerance, in one of their four orders."""
        a, b, c = at
        options = []
        for x, y in product((1.0, -1.0), repeat=2):
            rows = []
            for normal in ((-x, 0.0), (0.0, -y)):
                rows += [
                    LinearConstraint(b, c, normal, OUTLINE_SLACK_M),
                    LinearConstraint(b, a, normal, rule.tolerance + OUTLINE_SLACK_M),
                    LinearConstraint(a, c, normal, rule.tolerance + OUTLINE_SLACK_M),
                ]
            options.append(tuple(rows))
        yield tuple(options)

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        yield WeakerNumber("tolerance", rule.tolerance, rule.tolerance + WIDEST_M, with_tolerance)


RELATION = Between()
