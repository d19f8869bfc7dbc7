"""What a relation is to the compiler: one object with a method for each use that a phase has of it.

Defaults are those of a relation that nothing is known of: always sound, never helpful. A file of this folder overrides
what it knows. Frames as in `scenec.ir.problem`; B is the background's. Lengths in metres, angles in radians.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Problem, Proof
from scenec.plan.cases.motions import Motions
from scenec.plan.cases.rectangles import AxisOrder
from scenec.proofs.constraints import Difference, LinearConstraint, NodePose
from scenec.solve.frames import Pose2
from scenec.solve.placed import Placed
from scenec.solve.region_geometry import Box
from scenec.solve.shapes import ShapeAtYaw
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.relations import Relation, RelationWord
from source.tree import Path

Assignment = Mapping[str, Placed]
SUGGESTION_STEP_M = 0.001
WIDEST_M = 1.28  # by which a number is widened at most

AXES = {"x": (1.0, 0.0), "y": (0.0, 1.0)}


class Frames(Protocol):
    """The frames of one written relation at `path`."""

    @property
    def path(self) -> Path:
        """Where the relation is written."""
        ...

    def along(self, axis: tuple[float, float], members: tuple[str, ...]) -> tuple[str, tuple[float, float]]:
        """The owner of the frame for these members, and the axis in it. Raises InvalidInput."""
        ...

    def part_heading_rad(self, name: str) -> float | None:
        """Heading at yaw 0 of the part that the relation names of a thing, None where it names none. Raises
        InvalidInput."""
        ...


class Mover(NamedTuple):
    """A thing that is being placed: its shape, the pose in B of its owner, the box in P of where its origin may be, the
    height in P of what it rests on."""

    name: str
    turned: ShapeAtYaw
    owner: Pose2
    around: Box
    base_P_m: float


class Batch(Protocol):
    """The members of a relation in many layouts (...), in the frame P of their owner.

    `numbers` are their places in the relation: not all of them are there where it constrains early.
    """

    @property
    def numbers(self) -> Sequence[int]:
        """The number of each member in the relation."""
        ...

    @property
    def rects_m(self) -> Sequence[FloatArray]:
        """Rectangles (..., 4) around the footprints."""
        ...

    @property
    def origins_m(self) -> Sequence[FloatArray]:
        """Origins (..., 2)."""
        ...

    @property
    def fronts_rad(self) -> Sequence[FloatArray]:
        """Headings (...) of the fronts."""
        ...

    @property
    def heights_m(self) -> Sequence[tuple[FloatArray, FloatArray]]:
        """Lowest and highest z (...) in P of each member, without what it carries."""
        ...


@dataclass(frozen=True)
class WeakerNumber:
    """A number of a relation that can be weakened: its key and value as written, how far it may go, on which raster.

    `changed` gives the relation with another value; `cost_per_unit` ranks a change of it among others (1 a metre).
    """

    key: str
    start: float
    end: float
    changed: Callable[[SceneRelation, float], SceneRelation]
    step: float = SUGGESTION_STEP_M
    cost_per_unit: float = 1.0


class RelationMeaning(ABC):
    """The meaning of one kind of relation; `kind` is the name of its file.

    frame_dependent   its direction counts in the frame that the relation names
    separable         a coordinate along its direction keeps both sides apart, so that they can be solved independently
    lifts_to_owners   it holds for contents when it holds for the trays that carry them
    slow_to_measure   it measures distances of polygons: plans look at it last
    constrains_early  `region` and `may_hold` take any two of its members, the others not being placed yet
    bounds_heights    what lies in a receptacle may have to lie on other contents to fulfil it
    """

    kind: str
    frame_dependent: bool = False
    separable: bool = False
    lifts_to_owners: bool = False
    slow_to_measure: bool = False
    constrains_early: bool = False
    bounds_heights: bool = False

    # For the solver.

    @abstractmethod
    def excess(self, rule: SceneRelation, assignment: Assignment) -> float:
        """Violation in metres or radians, at most 0 where it holds. All things must be placed."""
        ...

    def region(self, rule: SceneRelation, mover: Mover, assignment: Assignment) -> BaseGeometry | None:
        """Where (in P) the origin of a thing may lie so that the relation holds, the others placed; None: left to
        `excess`."""
        return None

    def placed_last(self, rule: SceneRelation) -> tuple[str, ...]:
        """Members for which there is room only when the others are placed."""
        return ()

    def exact_yaw(self, rule: SceneRelation, placed: Placed, assignment: Assignment) -> float | None:
        """The yaw in P at which a member fulfils the relation exactly, the others placed; None where yaw is free."""
        return None

    # For plans.

    @abstractmethod
    def may_hold(self, rule: SceneRelation, batch: Batch) -> BoolArray:
        """Whether it may hold in each layout (...): a necessary test on rectangles, exact where they decide."""
        ...

    def kept_by_rectangles(self, rule: SceneRelation) -> bool:
        """Whether disjoint rectangles in the right order imply it, so that cells need no clipping."""
        return False

    def axis_order(self, rule: SceneRelation) -> AxisOrder | None:
        """The order of two members along x or y that it demands, members by number."""
        return None

    def least_distance_m(self, rule: SceneRelation) -> float | None:
        """The least distance of the footprints of its two members, None where it demands none."""
        return None

    def most_distance_m(self, rule: SceneRelation) -> float | None:
        """The largest distance of the footprints of its two members, None where it allows any."""
        return None

    def clip_axes(self, rule: SceneRelation) -> slice:
        """The axes of P along which motion of its members matters."""
        return slice(None)

    def turns_matter(self, rule: SceneRelation, member: int, uneven: bool) -> bool:
        """Whether a member that turns about its origin may violate it; `uneven`: its footprint changes by turning."""
        return False

    def value(self, rule: SceneRelation, motions: Motions) -> FloatArray:
        """Measured value (l,) in each layout, as `holds_throughout` takes it."""
        return np.zeros_like(motions.axes_turn_rad)

    @abstractmethod
    def holds_throughout(self, rule: SceneRelation, motions: Motions, value: FloatArray) -> BoolArray:
        """(l,) whether it holds for every pose within the motions."""
        ...

    # For proofs: what every pose that fulfils it satisfies, never more.

    def refuted(self, rule: SceneRelation, problem: Problem) -> Proof | None:
        """A proof that nothing fulfils this relation, whatever the others are."""
        return None

    def difference_axes(self, rule: SceneRelation, along: FloatArray) -> tuple[FloatArray, ...]:
        """Axes (2,) along which it bounds differences, for its direction `along`."""
        return ()

    def differences(self, rule: SceneRelation, along: FloatArray | None, axis: FloatArray) -> Iterator[Difference]:
        """Differences along an axis that it implies; `along` is None where the yaw of its frame is not fixed."""
        yield from ()

    def linear_rows(
        self, rule: SceneRelation, at: Sequence[int], poses: Sequence[NodePose], along: FloatArray | None
    ) -> Iterator[LinearConstraint]:
        """Linear constraints of the origins of its members, which have the numbers `at`."""
        yield from ()

    def disjunctions(
        self, rule: SceneRelation, at: Sequence[int]
    ) -> Iterator[tuple[tuple[LinearConstraint, ...], ...]]:
        """Sets of options: of each set at least one option, a set of constraints, holds."""
        yield from ()

    def heading_matters(self, rule: SceneRelation, name: str) -> bool:
        """Whether the heading of a member matters even if its outline is symmetric."""
        return False

    # For suggestions.

    def weaker(self, rule: SceneRelation) -> Iterator[WeakerNumber]:
        """Numbers whose change makes it easier to fulfil."""
        yield from ()


class WordMeaning(RelationMeaning):
    """The meaning of a kind that words of the language write. `page` is what the language page says: a row (word,
    arguments, when it holds) for each word."""

    page: tuple[tuple[str, str, str], ...]

    @abstractmethod
    def lower(
        self, written: Relation, word: RelationWord, sides: Sequence[tuple[str, ...]], frames: Frames
    ) -> Iterator[SceneRelation]:
        """Relations between things from the written one; `sides` are the things that each written name stands for."""
        ...


def with_gap(rule: SceneRelation, value: float) -> SceneRelation:
    """The relation with another gap or distance."""
    return replace(rule, gap_m=value)


def with_tolerance(rule: SceneRelation, value: float) -> SceneRelation:
    """The relation with another tolerance."""
    return replace(rule, tolerance=value)


def distance_relations(
    written: Relation, pairs: Iterable[tuple[str, str]], path: Path, word: str
) -> Iterator[SceneRelation]:
    """`near` and `far_from` for a written `distance`: one number bounds it from above, two from both sides."""
    if written.distance is None:
        return
    is_range = isinstance(written.distance, tuple)
    low, high = written.distance if isinstance(written.distance, tuple) else (0.0, written.distance)
    for pair in pairs:
        yield SceneRelation("near", pair, gap_m=high, path=path, word=word, key="distance[1]" if is_range else "")
        if is_range:
            yield SceneRelation("far_from", pair, gap_m=low, path=path, word=word, key="distance[0]")


def along_axis(cosine: float) -> bool:
    """Whether two unit directions with this cosine are parallel."""
    return abs(cosine) > 1.0 - 1e-12
