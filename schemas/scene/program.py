"""The scene program: the YAML language of `scenec` as data (design: scene program).

Lengths in metres, angles in radians; `*_deg` keys take degrees. x, y, z of ranges and poses are those of the anchor's
frame: origin at the bounding-box centre of its polygon, axes of the asset that owns it. Unknown keys are errors.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

BACKGROUND = "background"
Length = Annotated[float, Field(gt=0.0)]
Distance = Annotated[float, Field(ge=0.0)]
Range = tuple[float, float]
Point2 = tuple[float, float]
Point3 = tuple[float, float, float]
Quat_wxyz = tuple[float, float, float, float]


class _Written(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


# What an object is.


class BoxAsset(_Written):
    """A solid box that needs no package; its top face is the surface `top`."""

    type: Literal["box"]
    size_m: tuple[Length, Length, Length]
    mass_kg: Length | None = None
    color: str | None = None


class CylinderAsset(_Written):
    """A solid upright cylinder; its top face is the surface `top`."""

    type: Literal["cylinder"]
    radius_m: Length
    height_m: Length
    mass_kg: Length | None = None
    color: str | None = None


class SphereAsset(_Written):
    """A solid ball."""

    type: Literal["sphere"]
    radius_m: Length
    mass_kg: Length | None = None
    color: str | None = None


class FixedAsset(_Written):
    """One package by its asset id."""

    type: Literal["fixed"]
    id: str


class AssetCandidates(_Written):
    """A named set of packages that may replace one another."""

    id: str
    assets: tuple[str, ...] = Field(min_length=1)


class PoolAsset(_Written):
    """Any of the candidates; all must be able to play the object's role."""

    type: Literal["pool"]
    candidates: tuple[AssetCandidates, ...] = Field(min_length=1)


Inline: TypeAlias = BoxAsset | CylinderAsset | SphereAsset
Asset: TypeAlias = Annotated[
    BoxAsset | CylinderAsset | SphereAsset | FixedAsset | PoolAsset, Field(discriminator="type")
]


class SceneObject(_Written):
    """One thing of the scene under its stable id."""

    id: str
    asset: Asset | str
    role: str | None = None
    semantic_tags: tuple[str, ...] = ()
    scale: Length = 1.0


class Background(_Written):
    """The fixed environment under all objects. Its frame is the world's unless `position`, `yaw` say otherwise."""

    asset: Asset | str
    scale: Length = 1.0
    position: Point3 = (0.0, 0.0, 0.0)
    yaw: float | None = None
    yaw_deg: float | None = None


# Where things may be.


class AuthoredPolygon(_Written):
    """A surface or opening drawn by hand in the owning asset's frame, at height `z`."""

    outline: tuple[Point2, ...] = Field(min_length=3)
    holes: tuple[tuple[Point2, ...], ...] = ()
    z: float = 0.0
    height: Length | None = Field(default=None, description="free height above it; of a volume: its usable height")


class AnchorRef(_Written):
    """A named place of an object: `auto` takes its main surface or volume, a name one of the package."""

    object: str
    surface: Literal["auto"] | str | AuthoredPolygon | None = None
    volume: Literal["auto"] | str | AuthoredPolygon | None = None


class Ranges(_Written):
    """Bounds of the asset origin and heading in the anchor's frame; what is absent is free."""

    x: Range | None = None
    y: Range | None = None
    yaw: Range | None = None
    yaw_deg: Range | None = None


class Pose(_Written):
    """A complete pose in the anchor's frame; `z` is the height of the asset origin over the anchor."""

    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None
    yaw_deg: float | None = None
    quat_wxyz: Quat_wxyz | None = None


Orientation: TypeAlias = Literal["upright", "stable"] | tuple[Quat_wxyz, ...]


class SurfacePlacement(_Written):
    """Placement on a surface, the footprint wholly on its polygon."""

    type: Literal["surface"]
    surface: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class VolumePlacement(_Written):
    """Inside a receptacle, on its floor or on what lies there."""

    type: Literal["volume"]
    volume: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class DiscretePlacement(_Written):
    """One of the poses written down, in the frame of an anchor."""

    type: Literal["discrete"]
    surface: str | None = None
    volume: str | None = None
    poses: tuple[Pose, ...] = Field(min_length=1)


Placement: TypeAlias = Annotated[SurfacePlacement | VolumePlacement | DiscretePlacement, Field(discriminator="type")]


class LayoutNode(_Written):
    """One placed thing. Without `placement` a group must own it."""

    object: str
    placement: Placement | None = None


class RegionGroup(_Written):
    """Members share a stretch of a support."""

    type: Literal["region"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class ScatterGroup(_Written):
    """A denser, repeated collection: `count` copies of each member's object where it is given."""

    type: Literal["scatter"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str
    count: Annotated[int, Field(ge=1)] = 1
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class VolumeGroup(_Written):
    """Members lie together in a receptacle."""

    type: Literal["volume"]
    members: tuple[str, ...] = Field(min_length=1)
    volume: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class Slot(_Written):
    """One authored place of a slot group."""

    id: str
    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None
    yaw_deg: float | None = None


class SlotGroup(_Written):
    """Each member takes a slot of its own; `assign` fixes which."""

    type: Literal["slot"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str | None = None
    volume: str | None = None
    slots: tuple[Slot, ...] = Field(min_length=1)
    assign: dict[str, str] = {}


Group: TypeAlias = Annotated[RegionGroup | ScatterGroup | VolumeGroup | SlotGroup, Field(discriminator="type")]


class Layout(_Written):
    """Every placed node has exactly one owner: itself by `placement`, or one group."""

    nodes: dict[str, LayoutNode] = {}
    groups: dict[str, Group] = {}


# How things stand to one another.


class Relation(_Written):
    """One relation between placed nodes; exactly one of the first keys is given.

    The default viewer is at -y of the support's frame and looks toward +y: `left_of: [a, b]` puts the whole
    footprint of a at smaller x than that of b, by `gap`; `behind` at larger y. `frame` names the anchor or object whose
    axes count, `viewpoint` turns the viewer. `near` and `far_from` bound the distance of footprints, `aligned` the
    offset of origins across `axis`, `facing` turns the front (+x) of a toward b, `between: [a, b, c]` puts a's origin
    between those of b and c.
    """

    left_of: tuple[str, str] | None = None
    right_of: tuple[str, str] | None = None
    front_of: tuple[str, str] | None = None
    behind: tuple[str, str] | None = None
    near: tuple[str, str] | None = None
    far_from: tuple[str, str] | None = None
    aligned: tuple[str, ...] | None = Field(default=None, min_length=2)
    facing: tuple[str, str] | None = None
    between: tuple[str, str, str] | None = None
    gap: Distance = 0.0
    distance: Length | None = Field(default=None, description="of near (at most) and far_from (at least)")
    axis: Literal["x", "y"] = "x"
    tolerance: Distance | None = Field(default=None, description="aligned, between: metres; facing: radians")
    tolerance_deg: Distance | None = None
    frame: str | None = None
    viewpoint: Literal["front", "back", "left", "right"] = "front"


class KeepOut(_Written):
    """A region of a surface that must stay empty, up to `height` above it."""

    id: str
    surface: str
    outline: tuple[Point2, ...] | None = None
    ranges: Ranges | None = None
    height: Length | None = None


class Reach(_Written):
    """What a robot reaches: a ring around its base in the world, in which the origins of `members` must lie."""

    base: Point3
    radius: Length
    min_radius: Distance = 0.0
    members: tuple[str, ...] | Literal["all"] = "all"


# What may vary.


class PairedMaterial(_Written):
    """A render recipe and the physics that belongs to it."""

    id: str
    objects: tuple[str, ...]
    base_color: tuple[float, float, float] | None = None
    roughness: float | None = None
    metallic: float | None = None
    density_kgm3: Length | None = None
    static_friction: Distance | None = None
    dynamic_friction: Distance | None = None
    restitution: Distance | None = None


class Lighting(_Written):
    """A lighting set-up with bounded channels: intensity, exposure, colour temperature, dome rotation."""

    id: str
    intensity: Range | None = None
    exposure: Range | None = None
    temperature_K: Range | None = None
    rotation: Range | None = None


class SlotVariant(_Written):
    """Another assignment of a slot group."""

    id: str
    group: str
    assign: dict[str, str]


class AssetVariant(_Written):
    """Other assets for objects, chosen together."""

    id: str
    objects: dict[str, Asset | str]


class BackgroundVariant(_Written):
    """Another background."""

    id: str
    background: Background


class Variants(_Written):
    """Alternatives within one program; the first three change geometry and are resolved before placement."""

    assets: tuple[AssetVariant, ...] = ()
    backgrounds: tuple[BackgroundVariant, ...] = ()
    slots: tuple[SlotVariant, ...] = ()
    materials: tuple[PairedMaterial, ...] = ()
    lighting: tuple[Lighting, ...] = ()


class Split(_Written):
    """Assets for training and for evaluation; no asset may be in both."""

    train: tuple[str, ...] = ()
    eval: tuple[str, ...] = ()


class SceneProgram(_Written):
    """A whole program, includes resolved."""

    scene: str = "scene"
    definition: dict[str, object] = Field(default={}, description="free facts about the scene, such as scene_type")
    background: Background | None = None
    objects: tuple[SceneObject, ...] = ()
    anchors: dict[str, AnchorRef] = {}
    layout: Layout = Layout()
    relations: tuple[Relation, ...] = ()
    clearance: Distance = 0.01
    keep_outs: tuple[KeepOut, ...] = ()
    reach: Reach | None = None
    variants: Variants = Variants()
    split: Split = Split()
