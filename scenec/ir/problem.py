"""The placement problem: one combination of a program bound to geometry, input of analysis, solver and emitter.

Frames: W world; P an asset frame (the owner of a place); A an anchor frame (origin at the bounding-box centre of its
polygon, axes of P); S a stance: the asset frame turned by one allowed orientation, before yaw. Metres, radians.
Every item keeps its `path` in the program, from which `Spans` gives file, line and column.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from shapely import Polygon

from schemas.arrays import FloatArray
from schemas.scene.program import BACKGROUND
from schemas.scene.relations import WORD

Path = tuple[str | int, ...]
WORLD_PARENT = BACKGROUND
LEVEL_SHARE = 0.25  # of a floor that things stand on


@dataclass(frozen=True)
class Slab:
    """One convex collision shape of a stance: outline (n, 2) counter-clockwise in S, and the heights it spans over the
    support, so that the lowest slab of a stance begins at 0."""

    outline_m: FloatArray
    low_m: float
    high_m: float


@dataclass(frozen=True)
class Stance:
    """A resting orientation: `quat_wxyz` turns the asset frame; the asset origin is `origin_height_m` over the
    support."""

    quat_wxyz: tuple[float, float, float, float]
    slabs: tuple[Slab, ...]
    origin_height_m: float
    name: str = "upright"

    @property
    def height_m(self) -> float:
        """Height of the highest point over the support."""
        return max(slab.high_m for slab in self.slabs)


@dataclass(frozen=True)
class Surface:
    """A polygon in A to stand on; `clearance_m` is the free height over it, inf where the sky is free.

    `above` are slabs of the owner itself over the surface (rims, shelf posts), in A with heights over the surface.
    """

    name: str
    polygon: Polygon
    origin_P_m: FloatArray  # (3,)
    clearance_m: float = np.inf
    above: tuple[Slab, ...] = ()


@dataclass(frozen=True)
class Volume:
    """The inside of a receptacle in A: `layers` are (low, high, polygon) from the floor up; origin on the floor."""

    name: str
    layers: tuple[tuple[float, float, Polygon], ...]
    opening: Polygon
    origin_P_m: FloatArray  # (3,)

    @property
    def height_m(self) -> float:
        """Usable height from the floor to the rim."""
        return self.layers[-1][1]

    @property
    def level_share(self) -> float:
        """Area of the floor as a share of the widest layer: 1 between upright walls, near 0 in a bowl."""
        return self.layers[0][2].area / max(area.area for _, _, area in self.layers)

    @property
    def is_round(self) -> bool:
        """Whether contents mostly lean on its walls, which placements here cannot describe."""
        return self.level_share < LEVEL_SHARE


@dataclass(frozen=True)
class Body:
    """Geometry of an asset, scale applied. `surfaces` and `volumes` in its upright frame P, main one first.

    `candidates` are the bodies whose union this one is, empty for a single asset.
    """

    asset_id: str
    resting_orientations: tuple[Stance, ...]
    surfaces: tuple[Surface, ...] = ()
    volumes: tuple[Volume, ...] = ()
    mass_kg: float | None = None
    package: str | None = None
    scale: float = 1.0
    inline: object | None = None  # the primitive as written, for the emitter
    candidates: tuple[Body, ...] = ()


@dataclass(frozen=True)
class FixedPose:
    """One complete pose in A: origin of the asset frame at (x, y, z), resting orientation number `stance`, yaw."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    name: str = ""
    path: Path = ()
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
    path: Path = ()


@dataclass(frozen=True)
class Thing:
    """One placed node: its body, and its place as owner (a thing's name, or WORLD_PARENT) and anchor of that owner."""

    name: str
    body: Body
    parent: str
    place: Surface | Volume
    domain: Domain
    path: Path
    group: str | None = None
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class RelationIR:
    """A relation between things; what its numbers mean is in `scenec.relations`, in the file of its `kind`.

    `direction` is a unit vector (2,) in the frame of `frame`, which is WORLD_PARENT or a thing. `word` is the one that
    was written, where it was.
    """

    kind: str
    things: tuple[str, ...]
    direction: tuple[float, float] = (1.0, 0.0)
    gap_m: float = 0.0
    tolerance: float = 0.0
    frame: str = WORLD_PARENT
    path: Path = ()
    word: str = ""

    @property
    def as_written(self) -> tuple[str, ...]:
        """The things in authored order."""
        return self.things[::-1] if self.word in WORD and WORD[self.word].reverse else self.things


@dataclass(frozen=True)
class KeepOutIR:
    """Part of a place that stays empty up to `height_m` above it: polygon in A. The place may carry nothing else."""

    parent: str
    place: Surface
    polygon: Polygon
    height_m: float
    path: Path


@dataclass(frozen=True)
class ReachIR:
    """A ring around `base_m` (3,) in W in which the origins of `members` must lie."""

    base_m: FloatArray
    least_m: float
    most_m: float
    members: tuple[str, ...]
    path: Path


@dataclass(frozen=True)
class Problem:
    """One combination, ready to analyse and solve."""

    scene: str
    background: Body | None
    X_WB: FloatArray  # (4, 4) background in the world
    things: tuple[Thing, ...]
    relations: tuple[RelationIR, ...]
    clearance_m: float
    keep_outs: tuple[KeepOutIR, ...] = ()
    reach: ReachIR | None = None
    combination: dict[str, str] = field(default_factory=dict)

    @cached_property
    def key(self) -> tuple[tuple[str, str], ...]:
        """Identifies it among the combinations of its program."""
        return tuple(sorted(self.combination.items()))


@dataclass(frozen=True)
class Placement:
    """Pose of a thing in the frame A of its place: asset origin, yaw, number of its resting orientation; `base_m` is
    the height of its lowest point over A (0 on a surface or the floor of a volume, more on other contents)."""

    x_m: float
    y_m: float
    yaw_rad: float
    stance: int
    base_m: float = 0.0


@dataclass(frozen=True)
class Proof:
    """Proof that there is no scene: `kind` of argument, `value` against `bound` in `unit`, `paths` of its premises."""

    kind: str
    text: str
    value: float
    bound: float
    unit: str
    paths: tuple[Path, ...]


@dataclass(frozen=True)
class Solved:
    """A complete assignment: placements by name of thing."""

    placements: dict[str, Placement]
    steps: int = 0


@dataclass(frozen=True)
class Infeasible:
    """There is no scene; `proof` is the reason."""

    proof: Proof


@dataclass(frozen=True)
class Exhausted:
    """No scene found within the step budget: number of things placed at best, and the thing that failed most often.

    `best_placements` is that partial assignment, for pictures only; it is never emitted as a scene. `note` is the
    reason why nothing was searched, where that is so.
    """

    placed: int
    of: int
    blocking: str
    steps: int
    best_placements: dict[str, Placement] = field(default_factory=dict)
    note: str = ""


Result = Solved | Infeasible | Exhausted
