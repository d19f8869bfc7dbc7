"""The scene program: the YAML language of `scenec` as data (design: scene program).

Lengths in metres, angles in radians; `*_deg` keys take degrees. x, y, z of ranges and poses are those of the anchor's
frame: origin at the bounding-box centre of its polygon, axes of the asset that owns it. Unknown keys are errors.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from schemas.scene.cameras import Camera
from schemas.scene.placing import Group, Placement, Ranges
from schemas.scene.relations import Relation
from schemas.scene.written import Distance, Length, Range, Written

Point2 = tuple[float, float]
Point3 = tuple[float, float, float]


JointPositions: TypeAlias = Annotated[
    dict[str, float],
    Field(
        exclude_if=lambda joints: not joints,  # programs without joints are dumped, and hashed, as if there were none
        description="positions of joints by name, in metres or radians; in degrees where `_deg` is added to the name. "
        "Joints that are left out are at rest",
    ),
]


# What an object is.


class BoxAsset(Written):
    """A solid box that needs no package; its top face is the surface `top`."""

    type: Literal["box"]
    size_m: tuple[Length, Length, Length]
    mass_kg: Length | None = None
    color: str | None = None


class CylinderAsset(Written):
    """A solid upright cylinder; its top face is the surface `top`."""

    type: Literal["cylinder"]
    radius_m: Length
    height_m: Length
    mass_kg: Length | None = None
    color: str | None = None


class SphereAsset(Written):
    """A solid ball."""

    type: Literal["sphere"]
    radius_m: Length
    mass_kg: Length | None = None
    color: str | None = None


class FixedAsset(Written):
    """One package by its asset id."""

    type: Literal["fixed"]
    id: str


class AssetCandidates(Written):
    """A named set of packages that may replace one another."""

    id: str
    assets: tuple[str, ...] = Field(min_length=1)


class PoolAsset(Written):
    """Any of the candidates; all must be able to play the object's role."""

    type: Literal["pool"]
    candidates: tuple[AssetCandidates, ...] = Field(min_length=1)


Inline: TypeAlias = BoxAsset | CylinderAsset | SphereAsset
Asset: TypeAlias = Annotated[
    BoxAsset | CylinderAsset | SphereAsset | FixedAsset | PoolAsset, Field(discriminator="type")
]


class SceneObject(Written):
    """One thing of the scene under its stable id."""

    id: str
    asset: Asset | str
    role: str | None = None
    semantic_tags: tuple[str, ...] = ()
    scale: Length = 1.0


class Background(Written):
    """The fixed environment under all objects. Its frame is the world's unless `position`, `yaw` say otherwise."""

    asset: Asset | str
    scale: Length = 1.0
    position: Point3 = (0.0, 0.0, 0.0)
    yaw: float | None = None
    yaw_deg: float | None = None
    height: Range | None = Field(
        default=None,
        exclude_if=lambda height: height is None,
        description="range of the height of its frame over `position`, m: plans draw it, and all on it rises",
    )
    joints: JointPositions = Field(default={})


# Where things may be.


class AuthoredPolygon(Written):
    """A surface or opening drawn by hand in the owning asset's frame, at height `z`."""

    outline: tuple[Point2, ...] = Field(min_length=3)
    holes: tuple[tuple[Point2, ...], ...] = ()
    z: float = 0.0
    height: Length | None = Field(default=None, description="free height above it; of a volume: its usable height")


class AnchorRef(Written):
    """A named place of an object: `auto` takes its main surface or volume, a name one of the package."""

    object: str
    surface: Literal["auto"] | str | AuthoredPolygon | None = None
    volume: Literal["auto"] | str | AuthoredPolygon | None = None


class LayoutNode(Written):
    """One placed thing. Without `placement` a group must own it."""

    object: str
    placement: Placement | None = None
    joints: JointPositions = Field(default={})


class Layout(Written):
    """Every placed node has exactly one owner: itself by `placement`, or one group."""

    nodes: dict[str, LayoutNode] = Field(default={})
    groups: dict[str, Group] = Field(default={})


class KeepOut(Written):
    """A region of a surface that must stay empty, up to `height` above it."""

    id: str
    surface: str
    outline: tuple[Point2, ...] | None = None
    ranges: Ranges | None = None
    height: Length | None = None


class KeepClearRule(Written):
    """The space that a joint of a placed object (or of the background) sweeps stays free of other objects."""

    object: str
    joint: str


class Distractors(Written):
    """Objects beside the task: between the two numbers of `count` of them in each draw, each any asset of the pool."""

    id: str
    pool: tuple[str, ...] = Field(min_length=1, description="ids of assets that the task does not use")
    count: tuple[Annotated[int, Field(ge=0)], Annotated[int, Field(ge=1)]] = Field(description="least and most")
    surface: str
    ranges: Ranges = Ranges()


class Reach(Written):
    """What a robot reaches: a ring around its base in the world, in which the origins of `members` must lie."""

    base: Point3
    radius: Length
    min_radius: Distance = 0.0
    members: tuple[str, ...] | Literal["all"] = "all"


# What may vary.


class PairedMaterial(Written):
    """A render recipe and the physics that belongs to it; `pair` names a shipped one that fills in what is absent."""

    id: str
    objects: tuple[str, ...]
    pair: str | None = None
    base_color: tuple[float, float, float] | None = None
    roughness: float | None = None
    metallic: float | None = None
    density_kgm3: Length | None = None
    static_friction: Distance | None = None
    dynamic_friction: Distance | None = None
    restitution: Distance | None = None


class Lighting(Written):
    """A lighting set-up with bounded channels: intensity, exposure, colour temperature, dome rotation."""

    id: str
    intensity: Range | None = None
    exposure: Range | None = None
    temperature_K: Range | None = None
    rotation: Range | None = None


class SlotVariant(Written):
    """Another assignment of a slot group."""

    id: str
    group: str
    assign: dict[str, str]


class AssetVariant(Written):
    """Other assets for objects, chosen together."""

    id: str
    objects: dict[str, Asset | str]


class BackgroundVariant(Written):
    """Another background."""

    id: str
    background: Background


class Variants(Written):
    """Alternatives within one program; the first three change geometry and are resolved before placement."""

    assets: tuple[AssetVariant, ...] = ()
    backgrounds: tuple[BackgroundVariant, ...] = ()
    slots: tuple[SlotVariant, ...] = ()
    materials: tuple[PairedMaterial, ...] = ()
    lighting: tuple[Lighting, ...] = ()


class Split(Written):
    """Assets for training and for evaluation; no asset may be in both."""

    train: tuple[str, ...] = ()
    eval: tuple[str, ...] = ()


class SceneProgram(Written):
    """A whole program, includes resolved."""

    scene: str = "scene"
    definition: dict[str, object] = Field(default={}, description="free facts about the scene, such as scene_type")
    background: Background | None = None
    objects: tuple[SceneObject, ...] = ()
    anchors: dict[str, AnchorRef] = Field(default={})
    layout: Layout = Layout()
    relations: tuple[Relation, ...] = ()
    clearance: Distance = 0.01
    keep_outs: tuple[KeepOut, ...] = ()
    keep_clear: tuple[KeepClearRule, ...] = Field(default=(), exclude_if=lambda rules: not rules)
    distractors: tuple[Distractors, ...] = Field(default=(), exclude_if=lambda rules: not rules)
    reach: Reach | None = None
    cameras: tuple[Camera, ...] = Field(default=(), exclude_if=lambda cameras: not cameras)
    variants: Variants = Variants()
    split: Split = Split()
