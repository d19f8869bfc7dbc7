"""RuntimeSamplingPlan: the compiler's output from which scenes are drawn at each reset (design 8).

Frames: W world, z up. U of an owner: its asset frame turned by yaw alone. A of a place: the axes of U, its origin at
the place. S of a stance: the asset frame turned by `quat_wxyz`, before yaw. Metres, radians; pools hold micrometres
(`_um`) and microradians (`_urad`), so that a plan is small, diffs by line and reads back to the same bits everywhere.

A **cell** is a rectangle in A that holds the whole footprint of its object. The cells of a case are apart by the
clearance, keep off obstacles and fulfil every relation for *any* poses inside them: a sample is valid by construction.
A pose is drawn so: a yaw uniformly from the intervals of the cell; then x and y uniformly where the footprint at that
yaw stays in the cell and the asset origin in its box: x in [x_low + r(-x), x_high - r(+x)], with r(d) the largest
extent of the stance's outlines in direction d at that yaw; the same in y.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.scene.cameras import Camera
from schemas.scene.compiled import Point2, Point3, Quat_wxyz
from schemas.scene.geometry import Prism
from schemas.scene.program import Inline, Lighting, PairedMaterial
from schemas.scene.relations import RelationKind

SCHEMA_VERSION = "1.1"
Family = Literal["grid", "free_rectangle", "shelf", "guillotine", "seeded", "strip", "point"]
Bounds_um = tuple[int, int, int, int]  # x_low, x_high, y_low, y_high
Interval_urad = tuple[int, int]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class PlanStance(_Model):
    """One resting orientation. `prisms` are the convex collision pieces in S, heights over the support."""

    name: str
    quat_wxyz: Quat_wxyz
    origin_height_m: float
    prisms: tuple[Prism, ...]


class PlanPolygon(_Model):
    """An outline with holes in A."""

    outline_m: tuple[Point2, ...]
    holes_m: tuple[tuple[Point2, ...], ...] = ()


class PlanLayer(_Model):
    """A slice of a volume: what its inside is between two heights over its floor."""

    low_m: float
    high_m: float
    polygon: PlanPolygon


class PlanPlace(_Model):
    """A surface (`polygon`) or the inside of a receptacle (`layers`); `height_m` is free height or rim, None: open sky.

    `above` are pieces of the owner over the place, in A. `origin_m` is the origin of A in U of the owner. `link` is the
    link of an articulated owner that carries the place.
    """

    name: str
    kind: Literal["surface", "volume"]
    origin_m: Point3
    polygon: PlanPolygon | None = None
    layers: tuple[PlanLayer, ...] = ()
    height_m: float | None = None
    above: tuple[Prism, ...] = ()
    link: str | None = Field(default=None, exclude_if=lambda link: link is None)


class PlanBody(_Model):
    """An asset at its scale. `package_hash` is the SHA-256 of its record, None for what needs no package. `joints` are
    (name, position in m or rad) of the joints of an articulated asset, at which they are held: the stances are those of
    this state."""

    asset_id: str
    package: str | None = None
    package_hash: str | None = None
    scale: float = 1.0
    mass_kg: float | None = None
    primitive: Annotated[Inline, Field(discriminator="type")] | None = None
    joints: tuple[tuple[str, float], ...] = Field(default=(), exclude_if=lambda joints: not joints)
    stances: tuple[PlanStance, ...]


class PlanSpot(_Model):
    """A pose that the author wrote: origin of the asset frame in A and yaw."""

    position_m: Point3
    yaw_rad: float
    stance: int = 0


class PlanThing(_Model):
    """One object of a combination. `bodies` are indices into `RuntimePlan.bodies`: any of them may be drawn, the cells
    hold for all. `parent` is a thing's id or `background`; `place` one of the combination's places. The ranges are
    those of the program, for who checks: of the asset origin in A, None where open; `spots`, if any, are all it has.
    """

    id: str
    bodies: tuple[int, ...]
    parent: str
    place: int
    x_m: tuple[float, float] | None = None
    y_m: tuple[float, float] | None = None
    yaw_rad: tuple[float, float] | None = None
    stances: tuple[int, ...] = (0,)
    spots: tuple[PlanSpot, ...] = ()
    semantic_tags: tuple[str, ...] = ()
    is_frame: bool = Field(
        default=False,
        exclude_if=lambda is_frame: not is_frame,
        description="the common frame of the members of a grid: drawn like a thing, but no object",
    )


class PlanRelation(_Model):
    """As `schemas.scene.geometry.SceneRelation`: `direction` (unit) counts in the frame U of `frame`, a thing's id or
    `background`.
    """

    kind: RelationKind
    things: tuple[str, ...]
    direction: Point2
    gap_m: float = 0.0
    tolerance: float = 0.0
    angle_rad: tuple[float, float] | None = Field(
        default=None, exclude_if=lambda angle: angle is None, description="least and largest, of the kinds with angles"
    )
    frame: str = "background"
    word: str = ""


class PlanKeepOut(_Model):
    """No object is over `polygon` (in A of a place) up to `height_m` above it."""

    place: int
    polygon: PlanPolygon
    height_m: float


class PlanKeepClear(_Model):
    """Space that `joint` of `owner` (a thing's id or `background`) sweeps: no other object is in it, but what the moved
    `links` carry and what the owner stands on. `layers` are upright prisms in U of the owner, heights over its asset
    origin."""

    owner: str
    joint: str
    links: tuple[str, ...]
    layers: tuple[PlanLayer, ...]


class PlanDistractors(_Model):
    """Things of which `least` to `most` are present in a sample, the number drawn uniformly."""

    things: tuple[str, ...]
    least: int
    most: int


class PlanReach(_Model):
    """Origins of `members` lie between two distances of `base_m` (W), seen from above."""

    base_m: Point3
    least_m: float
    most_m: float
    members: tuple[str, ...]


class PlanCase(_Model):
    """One joint choice for the objects of a pool, in their order. `origins_um` bound the asset origin besides the cell
    (None: the cell alone); equal ends pin it, as equal ends of a yaw do. `base_um` is the height of the support point
    over A (0 unless it is stacked on contents or was written). `weight` is the share of draws, relative."""

    family: Family
    weight: float = 1.0
    quality: float = 0.0
    cells_um: tuple[Bounds_um, ...]
    origins_um: tuple[Bounds_um | None, ...]
    yaws_urad: tuple[tuple[Interval_urad, ...], ...]
    stances: tuple[int, ...]
    base_um: tuple[int, ...]


class PlanPool(_Model):
    """Things chosen together: of one owner, or of several that a relation across them ties. A single thing with a
    domain of its own is a pool of one."""

    things: tuple[str, ...]
    cases: tuple[PlanCase, ...]


class PlanCombination(_Model):
    """One combination of geometry-changing variants. `things` owners first; pools are drawn independently."""

    combination: dict[str, str] = {}
    weight: float = 1.0
    background: int | None = None
    X_WB: tuple[tuple[float, float, float, float], ...] = Field(description="(4, 4) pose of the background in W; level")
    places: tuple[tuple[str, PlanPlace], ...] = Field(description="owner (a thing's id or background) and place")
    things: tuple[PlanThing, ...]
    pools: tuple[PlanPool, ...]
    relations: tuple[PlanRelation, ...] = ()
    keep_outs: tuple[PlanKeepOut, ...] = ()
    keep_clear: tuple[PlanKeepClear, ...] = Field(default=(), exclude_if=lambda rules: not rules)
    rise_m: float = Field(
        default=0.0,
        exclude_if=lambda rise: rise == 0.0,
        description="by how much a sample may raise the background and all that stands on it, m",
    )
    stacks: tuple[tuple[str, ...], ...] = Field(
        default=(),
        exclude_if=lambda stacks: not stacks,
        description="things that stand on one another, the lowest first",
    )
    distractors: tuple[PlanDistractors, ...] = Field(default=(), exclude_if=lambda rules: not rules)
    reach: PlanReach | None = None
    materials: tuple[str, ...] = Field(default=(), description="ids of the paired materials that fit its assets")
    lighting: tuple[str, ...] = Field(default=(), description="ids of the lightings valid with it")

    @property
    def objects(self) -> tuple[PlanThing, ...]:
        """The things that are objects: all but the frames of grids."""
        return tuple(thing for thing in self.things if not thing.is_frame)

    def standing_on(self, thing: PlanThing) -> tuple[str, int]:
        """Owner and place on which a thing stands: those of its grid for the members of one."""
        frame = next((other for other in self.things if other.is_frame and other.id == thing.parent), thing)
        return frame.parent, frame.place


class PlanProvenance(_Model):
    """What the plan was made from. Hashes are SHA-256; `compiler` names Mana's version."""

    program: str
    program_hash: str
    compiler: str
    seed: int
    diversity: float = 1.0
    restricted_from: str | None = Field(default=None, description="SHA-256 of the plan of which this is a part")


class RuntimePlan(_Model):
    """Compile once, sample many. Combinations in a fixed order; nothing here needs a package to be verified."""

    schema_version: str = SCHEMA_VERSION
    scene: str
    clearance_m: float
    bodies: tuple[PlanBody, ...]
    combinations: tuple[PlanCombination, ...]
    materials: tuple[PairedMaterial, ...] = ()
    lighting: tuple[Lighting, ...] = ()
    cameras: tuple[Camera, ...] = Field(default=(), exclude_if=lambda cameras: not cameras)
    split: dict[str, tuple[str, ...]] = Field(default={}, description="asset ids for train and eval; empty: all")
    provenance: PlanProvenance
