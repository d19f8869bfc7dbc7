"""AssetRecord: everything known about one released asset, each value with its evidence (design: asset package)."""

from __future__ import annotations

from enum import StrEnum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.acceptance import AcceptanceSection
from schemas.affordances import AffordanceEvidence
from schemas.anchors import Anchor
from schemas.appearance.record import AppearanceSection
from schemas.appearance.retopology import RetopologySection
from schemas.arrays import FloatArray
from schemas.articulation import JointUse
from schemas.diagnostics import Diagnostic
from schemas.evidence import Evidence, default
from schemas.model import Axis
from schemas.outcome import ItemOutcome, Repair
from schemas.parts import Part
from schemas.physics import Contact, Fidelity

SCHEMA_VERSION = "1.0"
RECORD = "record.json"
Vec3 = tuple[float, float, float]
Matrix3 = tuple[Vec3, Vec3, Vec3]
Quat_wxyz = tuple[float, float, float, float]


def vec3(values: FloatArray) -> Vec3:
    """(3,) as plain numbers."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def quat4(values: FloatArray) -> Quat_wxyz:
    """(4,) as plain numbers."""
    w, x, y, z = (float(v) + 0.0 for v in values)
    return w, x, y, z


def matrix3(values: FloatArray) -> Matrix3:
    """(3, 3) as plain numbers, row by row."""
    a, b, c = (vec3(row) for row in values)
    return a, b, c


Role = Literal[
    "manipulated",
    "receptacle",
    "tool",
    "fixture",
    "mechanism",
    "support",
    "distractor",
    "openable",
    "turnable",
    "pressable",
]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class SourceFile(_Section):
    """One file the asset was read from, relative to the asset's root."""

    path: str
    sha256: str
    bytes: int


class SourceSection(_Section):
    """Where the asset comes from. The licence is never invented: unknown is `default` with confidence 0."""

    format: str
    files: tuple[SourceFile, ...]
    meters_per_unit: Evidence[float]
    up_axis: Evidence[Axis]
    license: Evidence[str]
    author: Evidence[str]
    generator: str = ""
    nodes: int = 0
    source_names: dict[str, str] = Field(default_factory=dict, description="prim name -> name in the source")


class Topology(_Section):
    """What was counted on a triangle mesh after welding equal points. Lengths in metres (or source units before
    canonicalisation), areas and volumes accordingly.
    """

    name: str
    points: int
    triangles: int
    extent: Vec3
    components: int
    degenerate_faces: int
    duplicate_faces: int
    boundary_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    inconsistent_edges: int
    inverted: bool
    watertight: bool
    duplicate_shells: int = 0
    inner_shells: int = 0
    fragments: int = 0
    thin_parts: int = 0
    area: float = 0.0
    volume: float | None = None


class AnnotationFrame(_Section):
    """Centring and scaling used for annotation views only; it never changes the metric asset.

    A point p in the asset frame (metres) appears at `(p - centre_m) / scale_m` in the annotation frame.
    """

    centre_m: Vec3
    scale_m: float


class ShapeDescriptor(_Section):
    """Rotation- and scale-invariant figures of a surface in units of `scale_m`.

    All are area-weighted, so that the tessellation hardly matters.

    scale_m         root mean square distance of the surface from its area centroid.
    second_moments  principal second moments about the centroid, largest first; they add up to 1.
    third_moments   norm of the third-moment tensor and of its trace vector `v_i = T_ijj`.
    distances       quantiles of the distance between two random surface points (Osada et al. 2002, D2), at the middles
                    of equal shares.
    """

    scale_m: float
    second_moments: tuple[float, float, float]
    third_moments: tuple[float, float]
    distances: tuple[float, ...]


class GeometrySection(_Section):
    """Size, frame and topology of the canonical asset (metres, z-up, origin at the bottom centre)."""

    extent_m: Evidence[Vec3]
    origin_offset_m: Vec3 = Field(description="source origin, seen from the asset frame, in metres")
    source_quat_wxyz: Quat_wxyz = Field(
        default=(1.0, 0.0, 0.0, 0.0), description="axes of the source, seen from the asset frame"
    )
    annotation_frame: AnnotationFrame
    observed: tuple[Topology, ...] = Field(description="per mesh as read, or as retopology made it, then `merged`")
    reobserved: Topology
    solid_kind: Literal["closed", "shell", "hull"]
    volume_m3: Evidence[float]
    surface_area_m2: float
    wall_thickness_m: Evidence[float] | None = Field(default=None, description="of an open surface, else absent")
    repaired_distance_m: Evidence[float] | None = Field(
        default=None, description="two-way Hausdorff distance between the visible surface as read and as released"
    )
    solid_distance_m: Evidence[float] | None = Field(
        default=None,
        description="how far the physical surface lies from the visible one, or visible parts outside of it",
    )
    shape: ShapeDescriptor | None = Field(
        default=None, exclude_if=lambda shape: shape is None, description="of the visible surface, for near-duplicates"
    )


class CategoryHypothesis(_Section):
    """A category of the vocabulary, the chance that it is right, and the clues for and against it in words."""

    category: str
    score: float
    clues: tuple[str, ...]


class UprightHypothesis(_Section):
    """A direction of the source that may be up in the reference pose, its chance, and the signs in words.

    `alike` are other directions in which the object looks the same; the chance is that of all of them.
    """

    up: Vec3
    chance: float
    signs: tuple[str, ...]
    alike: tuple[Vec3, ...] = ()


class EndpointAnswer(_Section):
    """Answer of a multimodal model on the pictures, before names and shape were weighed against it.

    `categories` and `roles` are of the controlled vocabulary, with the model's own confidence; `refused` are its
    words outside it. `description` is its free text, cleaned and cut: words of a stranger, never a value. `settings`
    are those that the endpoint took.
    """

    method: str
    categories: dict[str, float]
    roles: dict[str, float]
    description: str
    refused: tuple[str, ...] = ()
    settings: dict[str, float] = {}


class SemanticsSection(_Section):
    """Meaning of an object; unknown values are `default` with confidence 0.

    `category` and `family` are of the controlled vocabulary, unless the user stated another category;
    `interaction_group` is that of most joints, else how things of the category move when they are articulated.
    `hypotheses` are all categories that came into question, best first; `source_texts` what the source calls the object
    and its parts, as it stands.
    """

    name: str
    category: Evidence[str]
    family: Evidence[str] = default("unknown")
    interaction_group: Evidence[str] | None = None
    roles: tuple[Evidence[str], ...]
    qcode: Evidence[str]
    hypotheses: tuple[CategoryHypothesis, ...] = ()
    source_texts: tuple[str, ...] = ()
    endpoint_answer: EndpointAnswer | None = None
    scale: Evidence[float] | None = Field(
        default=None, description="metres per source unit by what the thing is; absent where the unit is reliable"
    )
    upright: Evidence[Vec3] = Field(
        default=default((0.0, 0.0, 1.0)), description="direction of the source that is up in the reference pose"
    )
    uprights: tuple[UprightHypothesis, ...] = Field(default=(), description="ways up, the likeliest first")
    front: Evidence[Vec3] = Field(
        default=default((1.0, 0.0, 0.0)),
        description="level direction of the asset frame that is its front: +x; confidence 0 where nothing tells one",
    )
    heading_symmetry: Evidence[int] = Field(
        default=default(1), description="in how many headings it looks the same; 1 none, 0 all"
    )


class MassPart(_Section):
    """One substance of an object: the visual meshes it is seen on, its shares of volume and mass, its contacts."""

    meshes: tuple[str, ...]
    material: Evidence[str]
    density_kgm3: Evidence[float]
    volume_share: float
    mass_share: float
    contacts: tuple[Evidence[Contact], ...] = ()


class ColliderMaterial(_Section):
    """Which material a collision shape touches as, and the share of its surface that each one has in what it covers."""

    collider: str
    material: str
    shares: dict[str, float]


class LinkSection(_Section):
    """One link of an articulated object; mass properties in the asset frame at rest. `members` are the source's links
    that are welded into it, `origin_m` is where its frame lies.
    """

    name: str
    members: tuple[str, ...]
    origin_m: Vec3
    material: Evidence[str]
    density_kgm3: Evidence[float]
    mass_kg: Evidence[float]
    centre_of_mass_m: Evidence[Vec3]
    inertia_kgm2: Evidence[Matrix3]
    collision_method: str
    candidates: tuple[Fidelity, ...]

    @property
    def collider_misses_bounds(self) -> bool:
        """Whether the chosen collider misses a bound."""
        return not any(c.accepted for c in self.candidates if c.method == self.collision_method)


class PhysicsSection(_Section):
    """Mass properties about the mass centre in the asset frame, contact records, collider choice.

    `material` is that which most of the body touches as, by names, use and looks: of the largest share of volume with
    several `mass_parts`, whose own materials are those of their density. `density_kgm3` is then total mass over total
    volume. Of an articulated object the values are those of all `links` at rest, and `joints` connect these.
    """

    material: Evidence[str]
    density_kgm3: Evidence[float]
    mass_kg: Evidence[float]
    centre_of_mass_m: Evidence[Vec3]
    inertia_kgm2: Evidence[Matrix3]
    mass_parts: tuple[MassPart, ...] = ()
    contacts: tuple[Evidence[Contact], ...]
    collision_method: str
    candidates: tuple[Fidelity, ...]
    collider_materials: tuple[ColliderMaterial, ...] = Field(default=(), description="where parts differ in material")
    joints: tuple[Evidence[dict[str, Any]], ...] = ()
    links: tuple[LinkSection, ...] = Field(default=(), exclude_if=lambda links: not links)

    @property
    def collider_misses_bounds(self) -> bool:
        """Whether the chosen collider misses a bound, so that a person should look before anyone uses it."""
        if self.links:
            return any(link.collider_misses_bounds for link in self.links)
        return not any(c.accepted for c in self.candidates if c.method == self.collision_method)


class RepeatReason(StrEnum):
    """Why stages ran once more on an object, and the values that a record gives with it."""

    UNIT = "unit"  # the category decides the unit: meters_per_unit_before, meters_per_unit_after
    WAY_UP = "way_up"  # another direction of the source is up: turn_deg
    FRONT = "front"  # the front lies elsewhere than along +x: turn_deg about z, confidence


class RepeatedPass(_Section):
    """Stages that ran once more, in another frame, and the reasons with their values by name and unit."""

    stages: tuple[str, ...]
    reasons: dict[RepeatReason, dict[str, float]]


class StageEntry(_Section):
    """One line of the stage history: which stage ran, in which version, under which key; which passes it caused."""

    name: str
    version: int
    key: str
    repeats: tuple[RepeatedPass, ...] = Field(default=(), exclude_if=lambda passes: not passes)


class AssetRecord(_Section):
    """The machine-readable truth about one asset. No clock time and no absolute path ever appear in it."""

    schema_version: str = SCHEMA_VERSION
    asset_id: str
    outcome: ItemOutcome
    source: SourceSection
    geometry: GeometrySection
    appearance: AppearanceSection
    semantics: SemanticsSection
    parts: tuple[Evidence[Part], ...] = ()
    affordances: tuple[AffordanceEvidence, ...] = ()
    anchors: tuple[Evidence[Anchor], ...] = ()
    joint_uses: tuple[JointUse, ...] = Field(default=(), exclude_if=lambda uses: not uses)
    physics: PhysicsSection
    retopology: RetopologySection | None = Field(default=None, exclude_if=lambda section: section is None)
    acceptance: AcceptanceSection
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    history: tuple[StageEntry, ...] = ()
    hashes: dict[str, str] = Field(default_factory=dict, description="package file -> sha256")
