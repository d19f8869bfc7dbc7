"""The placement problem: one combination of a program bound to geometry, input of analysis, solver and emitter.

Frames: W world; P an asset frame (the owner of a place); A an anchor frame (origin at the bounding-box centre of its
polygon, axes of P); S a stance: the asset frame turned by one allowed orientation, before yaw. Metres, radians.
Every item keeps its `path` in the program, from which `Spans` gives file, line and column.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from schemas.arrays import FloatArray
from schemas.scene.geometry import Domain, KeepClear, KeepOutVolume, ReachRing, ScenePlace, SceneRelation, Stance
from source.tree import Path

LEVEL_SHARE = 0.25  # of a floor that things stand on


@dataclass(frozen=True)
class Body:
    """Geometry of an asset, scale applied. `surfaces` and `volumes` in its upright frame P, main one first.

    `candidates` are the bodies whose union this one is, empty for a single asset. `joints` are the positions (m, rad)
    of the joints of an articulated asset, by name: all else holds for this state.
    """

    asset_id: str
    resting_orientations: tuple[Stance, ...]
    surfaces: tuple[ScenePlace, ...] = ()
    volumes: tuple[ScenePlace, ...] = ()
    mass_kg: float | None = None
    package: str | None = None
    scale: float = 1.0
    inline: object | None = None  # the primitive as written, for the emitter
    candidates: tuple[Body, ...] = ()
    joints: tuple[tuple[str, float], ...] = ()
    parts: tuple[tuple[str, tuple[float, float]], ...] = ()  # names, each with its middle (x, y) in P


def level_share(place: ScenePlace) -> float:
    """Area of the floor of a volume as a share of its widest layer: 1 between upright walls, near 0 in a bowl."""
    return place.floor.area / max(layer.polygon.area for layer in place.layers)


def is_round(place: ScenePlace) -> bool:
    """Whether contents mostly lean on the walls of a place, which placements here cannot describe."""
    return place.is_volume and level_share(place) < LEVEL_SHARE


@dataclass(frozen=True)
class Thing:
    """One placed node: its body, and its place as owner (a thing's name, or BACKGROUND) and anchor of that owner."""

    name: str
    body: Body
    parent: str
    place: ScenePlace
    domain: Domain
    path: Path
    group: str | None = None
    tags: tuple[str, ...] = ()
    is_frame: bool = False  # the common frame of the members of a grid: placed like a thing, but no object


@dataclass(frozen=True)
class Problem:
    """One combination, ready to analyse and solve."""

    scene: str
    background: Body | None
    X_WB: FloatArray  # (4, 4) background in the world
    things: tuple[Thing, ...]
    relations: tuple[SceneRelation, ...]
    clearance_m: float
    keep_outs: tuple[KeepOutVolume, ...] = ()
    reach: ReachRing | None = None
    combination: dict[str, str] = field(default_factory=dict)
    keep_clear: tuple[KeepClear, ...] = ()
    rise_m: float = 0.0  # by how much plans raise the background and all that stands on it, at most
    stacks: tuple[tuple[str, ...], ...] = ()  # names of things that stand on one another, the lowest first

    @cached_property
    def frames(self) -> dict[str, Thing]:
        """The frames of grids, by name; they carry the members and are no objects."""
        return {thing.name: thing for thing in self.things if thing.is_frame}

    def standing_on(self, thing: Thing) -> tuple[str, ScenePlace]:
        """Owner and place on which a thing stands: those of its grid for the members of one."""
        frame = self.frames.get(thing.parent)
        return (thing.parent, thing.place) if frame is None else (frame.parent, frame.place)

    @cached_property
    def key(self) -> tuple[tuple[str, str], ...]:
        """Identifies it among the combinations of its program."""
        return tuple(sorted(self.combination.items()))

    def title(self, path: Path) -> str | None:
        """What reports call the constraint at a path, where that is more than the path: a space that a joint sweeps."""
        return next((space.title for space in self.keep_clear if space.path == path), None)


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
