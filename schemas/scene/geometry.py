"""Scene geometry shared by compiler, plans and judge: prisms, stances, places, domains, relations, keep-outs and reach.

Data only, frozen; algorithms stay with the packages that use them. Outlines are arrays, areas are shapely polygons
(arrays of corners that nobody can change). Metres, radians. Frames: W world, z up; P the asset frame of the owner of a
place, turned by yaw alone; A of a place, with the axes of P and its origin at the place; S of a stance: the asset frame
turned by one allowed orientation, before yaw. A `path` is where the program wrote an item, empty for all others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from schemas.arrays import FloatArray
from schemas.scene.relations import WORD

if TYPE_CHECKING:
    from shapely import Polygon

BACKGROUND = "background"  # the fixed surroundings, as owner of places and of frames
_DIGITS = 9  # of written lengths: nanometres


class _Points:
    """Points (n, 2) in documents: a list of pairs in JSON, an array in Python."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(
            _array,
            handler.generate_schema(tuple[tuple[float, float], ...]),
            serialization=core_schema.plain_serializer_function_ser_schema(np.ndarray.tolist),
        )


def _array(points: tuple[tuple[float, float], ...]) -> FloatArray:
    return np.array(points, dtype=np.float64).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Prism:
    """A convex piece of collision geometry: an outline (n, 2), counter-clockwise, and its lowest and highest z.

    In S, with heights over the support, as part of a stance; in A as part of a place; in W where it is placed.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        json_schema_extra={
            "description": "A convex piece of collision geometry seen from above: an outline in x and y, and the "
            "heights it spans."
        }
    )

    outline_m: Annotated[FloatArray, _Points]
    low_m: float
    high_m: float

    def rounded(self) -> Prism:
        """The prism as documents hold it: in whole nanometres, which hides rounding errors of sums."""
        return Prism(rounded_points(self.outline_m), rounded_value(self.low_m), rounded_value(self.high_m))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Prism) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @property
    def _content(self) -> tuple[float, float, bytes]:
        return self.low_m, self.high_m, self.outline_m.tobytes()


@dataclass(frozen=True, eq=False)
class Stance:
    """A resting orientation: `quat_wxyz` turns the asset frame into S; the asset origin is `origin_height_m` over the
    support, and the lowest of the `prisms` begins at 0."""

    quat_wxyz: tuple[float, float, float, float]
    prisms: tuple[Prism, ...]
    origin_height_m: float
    name: str = "upright"

    @property
    def height_m(self) -> float:
        """Height of the highest point over the support."""
        return max(prism.high_m for prism in self.prisms)


class PlaceLayer(NamedTuple):
    """A slice of a volume: the polygon in A that its inside is between two heights over the floor."""

    low_m: float
    high_m: float
    polygon: Polygon


@dataclass(frozen=True, eq=False)
class ScenePlace:
    """A surface to stand on, or the inside of a receptacle. `polygon`, in A, is the surface or the opening.

    `height_m` is the free height over a surface (inf under the open sky), or that of the rim over the floor. `layers`
    slice a volume from the floor up; a surface has none. `above` are pieces of the owner over a surface (rims, shelf
    posts), in A. `link` is the link of an articulated owner that carries the place, None of any other.
    """

    name: str
    polygon: Polygon
    origin_P_m: FloatArray  # (3,)
    height_m: float = np.inf
    above: tuple[Prism, ...] = ()
    layers: tuple[PlaceLayer, ...] = ()
    kind: Literal["surface", "volume"] = "surface"
    link: str | None = None

    @classmethod
    def volume(
        cls,
        name: str,
        layers: tuple[PlaceLayer, ...],
        opening: Polygon,
        origin_P_m: FloatArray,
        link: str | None = None,
    ) -> ScenePlace:
        """The inside of a receptacle; `origin_P_m` is on its floor, its rim at the top of its layers."""
        height_m = layers[-1].high_m if layers else 0.0
        return cls(name, opening, origin_P_m, height_m, layers=layers, kind="volume", link=link)

    @property
    def is_volume(self) -> bool:
        """Whether things go into it rather than onto it."""
        return self.kind == "volume"

    @property
    def floor(self) -> Polygon:
        """The area that things rest on."""
        return self.layers[0].polygon if self.layers else self.polygon


@dataclass(frozen=True)
class FixedPose:
    """One complete pose in A: origin of the asset frame at (x, y, z), resting orientation number `stance`, yaw."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    name: str = ""
    path: tuple[str | int, ...] = ()
    stance: int = 0


@dataclass(frozen=True)
class Domain:
    """Where one thing may be on its place. `fixed_poses`, when given, are the only ones; ranges bound its origin in A.

    `yaw_rad` is (low, high) with high - low <= 2 pi; equal ends fix it. `orientation_indices` number the allowed
    resting orientations of the body.
    """

    x_m: tuple[float, float] = (-np.inf, np.inf)
    y_m: tuple[float, float] = (-np.inf, np.inf)
    yaw_rad: tuple[float, float] = (-np.pi, np.pi)
    orientation_indices: tuple[int, ...] = (0,)
    fixed_poses: tuple[FixedPose, ...] = ()
    path: tuple[str | int, ...] = ()


@dataclass(frozen=True, eq=False)
class KeepOutVolume:
    """Part of a place of `parent` that stays empty up to `height_m` above it: polygon in A."""

    parent: str
    place: ScenePlace
    polygon: Polygon
    height_m: float
    path: tuple[str | int, ...] = ()


@dataclass(frozen=True, eq=False)
class KeepClear:
    """Space that the motion of a joint of `owner` (a thing's name, or BACKGROUND) needs: no other object is in it, but
    what the moved `links` carry and what the owner itself stands on. `layers` are upright prisms in P of the owner,
    their heights over its asset origin; they may overlap."""

    owner: str
    joint: str
    links: tuple[str, ...]
    layers: tuple[PlaceLayer, ...]
    path: tuple[str | int, ...] = ()

    @property
    def title(self) -> str:
        """What reports call it."""
        return f"keep_clear of {self.owner}.{self.joint}"


@dataclass(frozen=True, eq=False)
class ReachRing:
    """Origins of `members` lie between `least_m` and `most_m` from `base_m` (3,) in W, seen from above."""

    base_m: FloatArray
    least_m: float
    most_m: float
    members: tuple[str, ...]
    path: tuple[str | int, ...] = ()


@dataclass(frozen=True)
class SceneRelation:
    """A relation between things. What the numbers mean depends on its `kind`: `scenec.relations` has a file for each,
    `scene_check.relations` a predicate.

    `direction` is a unit vector (2,) in P of `frame`, which is BACKGROUND or a thing; the judge of one scene takes it
    in W. `word` is the one that was written, where it was, and `key` where its number is written, if not in the key
    that is usual for its kind. `zone` is the space that the second thing leaves free, of the kind that no word writes.
    """

    kind: str
    things: tuple[str, ...]
    direction: tuple[float, float] = (1.0, 0.0)
    gap_m: float = 0.0
    tolerance: float = 0.0
    frame: str = BACKGROUND
    path: tuple[str | int, ...] = ()
    word: str = ""
    angle_rad: tuple[float, float] | None = None
    key: str = ""
    zone: KeepClear | None = None

    @property
    def as_written(self) -> tuple[str, ...]:
        """The things in authored order."""
        return self.things[::-1] if self.word in WORD and WORD[self.word].reverse else self.things


def rounded_value(value: float) -> float:
    """A number as documents hold it (a length in whole nanometres), without negative zero."""
    return round(float(value), _DIGITS) + 0.0


def rounded_points(points_m: FloatArray) -> FloatArray:
    """Points (n, 2) in whole nanometres."""
    return np.array([[rounded_value(x) for x in point] for point in points_m.tolist()], dtype=np.float64).reshape(-1, 2)
