"""Input and output of the judge of scenes: objects, places, rules and violations; metres, in the world W unless stated.

Frame A of a place: its origin and yaw in W, z up.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from schemas.arrays import FloatArray
from schemas.scene.geometry import Domain, KeepClear, KeepOutVolume, Prism, ReachRing, ScenePlace, SceneRelation

TOLERANCE_M = 1e-6
TURN = 2.0 * np.pi
ViolationKind = Literal[
    "off_support", "unsupported", "headroom", "outside_volume", "owner_entered", "clearance", "penetration",
    "relation", "keep_out", "keep_clear", "reach", "range", "spot", "stance", "grid",
]  # fmt: skip


@dataclass(frozen=True)
class PosedPlace:
    """A place on or in an owner, with `origin_m` (3,) and `yaw_rad` of its frame A in W."""

    owner: str
    geometry: ScenePlace
    origin_m: FloatArray
    yaw_rad: float

    @cached_property
    def turn_WA(self) -> FloatArray:
        """(2, 2): horizontal directions as rows in W times this are those in A."""
        cos, sin = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return np.array([[cos, -sin], [sin, cos]])


@dataclass(frozen=True)
class CheckObject:
    """One placed object: origin of its asset frame (3,) and direction of its front (2,) in W, its prisms in W, and
    the poses that its program allows in A. `stance` is the number of the resting orientation; `is_known` is False where
    its orientation is none of them, and the nearest is given."""

    name: str
    prisms: tuple[Prism, ...]
    origin_m: FloatArray
    yaw_rad: float
    front: FloatArray
    place: PosedPlace
    domain: Domain = field(default_factory=Domain)
    stance: int = 0
    is_known: bool = True

    @cached_property
    def box_m(self) -> tuple[float, float, float, float]:
        """Bounding box (x0, y0, x1, y1) of the footprint in W."""
        corners = np.concatenate([prism.outline_m for prism in self.prisms])
        (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return x0, y0, x1, y1

    @cached_property
    def low_m(self) -> float:
        """Height of the lowest point in W."""
        return min(prism.low_m for prism in self.prisms)

    @cached_property
    def high_m(self) -> float:
        """Height of the highest point in W."""
        return max(prism.high_m for prism in self.prisms)


@dataclass(frozen=True)
class SweptSpace:
    """Space that a joint sweeps, with `origin_m` (3,) and `yaw_rad` of the asset frame of its owner in W."""

    space: KeepClear
    origin_m: FloatArray
    yaw_rad: float


@dataclass(frozen=True)
class PosedGrid:
    """Objects that keep their places relative to one another: `offsets_m` (n, 2) of their origins in the frame of the
    grid, whose origin and yaw in A of `place` are within `domain`."""

    name: str
    members: tuple[str, ...]
    offsets_m: FloatArray
    place: PosedPlace
    domain: Domain


@dataclass(frozen=True)
class CheckScene:
    """All placed objects with their rules; fixed surroundings are represented by their places. Each keep-out has its
    place in W, each swept space its owner; directions of relations are in W."""

    objects: tuple[CheckObject, ...]
    clearance_m: float
    relations: tuple[SceneRelation, ...] = ()
    keep_outs: tuple[tuple[PosedPlace, KeepOutVolume], ...] = ()
    reach: ReachRing | None = None
    keep_clear: tuple[SweptSpace, ...] = ()
    stacks: tuple[tuple[str, ...], ...] = ()  # names of objects that stand on one another, the lowest first
    grids: tuple[PosedGrid, ...] = ()


@dataclass(frozen=True)
class Violation:
    """The broken rule, the objects that break it, and the measured value against its bound in `unit`."""

    kind: ViolationKind
    names: tuple[str, ...]
    value: float
    bound: float
    unit: str = "m"
    label: str = ""


def owners_of(item: CheckObject, by_name: dict[str, CheckObject]) -> frozenset[str]:
    """Names of the owners of an object's place, owners of owners included."""
    names: list[str] = []
    while item.place.owner in by_name and item.place.owner not in names:
        names.append(item.place.owner)
        item = by_name[item.place.owner]
    return frozenset(names)


def same_place(place_a: PosedPlace, place_b: PosedPlace) -> bool:
    """Whether two places are the same."""
    return (place_a.owner, place_a.geometry.name) == (place_b.owner, place_b.geometry.name)


def changed_since(known: CheckScene | None, scene: CheckScene, by_name: dict[str, CheckObject]) -> frozenset[str]:
    """Names of objects that differ (`is not`) from those of `known`, or whose owners do; all where `known` is None."""
    if known is None or known.clearance_m != scene.clearance_m:
        return frozenset(by_name)
    before = {item.name: item for item in known.objects}
    fresh = {name for name, item in by_name.items() if before.get(name) is not item}
    return frozenset(
        name
        for name, item in by_name.items()
        if name in fresh
        or not (owners := owners_of(item, by_name)).isdisjoint(fresh)
        or owners != owners_of(item, before)
    )
