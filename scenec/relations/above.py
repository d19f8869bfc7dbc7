"""`above`, `below`: the lowest point of the first lies at least `gap_m` above the highest of the second, in world z.

What a member carries does not count as a part of it. With `overlap` the footprints overlap, too: that is a second
relation, `near` with distance 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from shapely.geometry.base import BaseGeometry
from typing_extensions import override

from scenec.ir.problem import Problem, Proof, Thing
from scenec.plan.cases.motions import Motions
from scenec.proofs.outlines import OUTLINE_SLACK_M
from scenec.relations.protocol import Assignment, Batch, Frames, Mover, WeakerNumber, WordMeaning, with_gap
from scenec.solve import measures
from scenec.solve.measures import SLACK
from scenec.solve.region_geometry import NOWHERE
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import BACKGROUND, SceneRelation
from schemas.scene.relations import Relation, RelationWord

Span = tuple[float, float]  # least and largest


class Above(WordMeaning):
    """See the module. Layouts of plans fix all heights, so that cells need no clipping."""

    kind = "above"
    page = (
        ("above", "[a, b]", "the lowest point of a is above the highest of b, by `gap`; `overlap`: footprints overlap"),
        ("below", "[a, b]", "likewise the highest point of a below the lowest of b"),
    )
    bounds_heights = True

    @override
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        for chosen in product(*sides):
            things = chosen[::-1] if word.reverse else chosen
            yield SceneRelation("above", things, gap_m=written.gap, path=frames.path, word=word.word)
            if written.overlap:
                yield SceneRelation("near", things, gap_m=0.0, path=frames.path, word=word.word)

    @override
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        (low, _), (_, high) = (measures.heights_B(assignment[name], assignment) for name in rule.things)
        return high + rule.gap_m - low

    @override
    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry | None:
        """Everywhere or nowhere: the height of a thing does not depend on where it lies."""
        floor, shape = mover.owner.z_m + mover.base_P_m, mover.turned.shape
        low, high = floor + shape.own_low_m, floor + shape.own_high_m
        if rule.things[0] == mover.name:
            _, high = measures.heights_B(assignment[rule.things[1]], assignment)
        else:
            low, _ = measures.heights_B(assignment[rule.things[0]], assignment)
        return None if high + rule.gap_m - low <= SLACK else NOWHERE

    @override
    def placed_last(self, rule: SceneRelation) -> tuple[str, ...]:
        return rule.things[:1]

    @override
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        (low, _), (_, high) = batch.heights_m
        return low - high >= rule.gap_m - SLACK

    @override
    def kept_by_rectangles(self, rule: SceneRelation) -> bool:
        return True

    @override
    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """The rise from the highest point of the second to the lowest of the first."""
        return motions.members[0].low_m - motions.members[1].high_m

    @override
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        return value >= rule.gap_m - SLACK

    @override
    def refuted(self, rule: SceneRelation, problem: Problem) -> Proof | None:
        """Places and orientations bound both heights over the innermost owner that carries both."""
        by_name = {thing.name: thing for thing in problem.things}
        above, below = (_owners(name, by_name) for name in rule.things)
        base = next((name for name in above if name in below), BACKGROUND)
        most = _heights(rule.things[0], by_name, base)[0][1]
        least = _heights(rule.things[1], by_name, base)[1][0]
        if most - least >= rule.gap_m - OUTLINE_SLACK_M:
            return None
        one, two = (by_name[name] for name in rule.things)
        text = (
            f"{one.name} must lie {rule.gap_m:.4g} m above {two.name}; their places allow {most - least:.4g} m at most"
        )
        return Proof("empty-domain", text, rule.gap_m, most - least, "m", (rule.path, one.path, two.path))

    @override
    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        if rule.gap_m > 0.0:
            yield WeakerNumber("gap", rule.gap_m, 0.0, with_gap)


def _owners(name: str, by_name: dict[str, Thing]) -> list[str]:
    """The thing and its movable owners, innermost first."""
    chain = []
    while name in by_name and name not in chain:
        chain.append(name)
        name = by_name[name].parent
    return chain


def _heights(name: str, by_name: dict[str, Thing], base: str) -> tuple[Span, Span]:
    """Spans of the lowest and of the highest z of a thing over the origin of a base that carries it or is it."""
    floors = _floors(by_name[name], by_name, base)
    prisms = [stance.prisms for stance in by_name[name].body.resting_orientations]
    lows = [
        (span[0] + min(s.low_m for s in prisms[k]), span[1] + min(s.low_m for s in prisms[k])) for k, span in floors
    ]
    highs = [
        (span[0] + max(s.high_m for s in prisms[k]), span[1] + max(s.high_m for s in prisms[k])) for k, span in floors
    ]
    return _joined(lows), _joined(highs)


def _floors(thing: Thing, by_name: dict[str, Thing], base: str) -> list[tuple[int, Span]]:
    """By orientation: the span of the height of what a thing rests on, over the origin of the base."""
    stances, domain = thing.body.resting_orientations, thing.domain
    if thing.name == base:
        heights = {k: stances[k].origin_height_m for k in domain.orientation_indices}
        return [(k, (-up, -up)) for k, up in heights.items()]
    low = high = float(thing.place.origin_P_m[2])
    if thing.parent != base and thing.parent in by_name:
        owner = by_name[thing.parent]
        spans = _floors(owner, by_name, base)
        heights = [owner.body.resting_orientations[k].origin_height_m for k, _ in spans]
        low += min(span[0] + up for (_, span), up in zip(spans, heights, strict=True))
        high += max(span[1] + up for (_, span), up in zip(spans, heights, strict=True))
    if domain.fixed_poses:
        over = [(pose.stance, pose.z_m - stances[pose.stance].origin_height_m) for pose in domain.fixed_poses]
        return [(k, (low + up, high + up)) for k, up in over]
    if not thing.place.is_volume:
        return [(k, (low, high)) for k in domain.orientation_indices]
    rises = {k: max(thing.place.height_m - stances[k].height_m, 0.0) for k in domain.orientation_indices}
    return [(k, (low, high + rise)) for k, rise in rises.items()]


def _joined(spans: Sequence[Span]) -> Span:
    lows, highs = np.array(spans).T
    return float(lows.min()), float(highs.max())


RELATION = Above()
