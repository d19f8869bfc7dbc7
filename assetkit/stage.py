"""The protocol of the stages, their result types, and the draft that collects the results of one object."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol, TypeVar

from pydantic import ConfigDict

from assetkit.options import Options
from assetkit.package.package import LastPackage
from assetkit.pose.front import Front
from assetkit.scale.declared_units import UnitDecision
from geom.features.cavities import Cavity
from jobs.cache import Cache
from schemas.acceptance import AcceptanceSection
from schemas.affordances import AffordanceEvidence
from schemas.anchors import Anchor
from schemas.appearance.material import Material, Texture
from schemas.appearance.record import AppearanceSection
from schemas.appearance.retopology import RetopologySection
from schemas.arrays import FloatArray
from schemas.articulation import JointUse, SweptVolume
from schemas.asset import GeometrySection, PhysicsSection, SemanticsSection, SourceFile
from schemas.diagnostics import Diagnostic
from schemas.evidence import Evidence, default
from schemas.mechanism import Mechanism
from schemas.model import Axis, Mesh, Model
from schemas.outcome import Outcome, Repair
from schemas.package import LinkBody
from schemas.parts import Part
from schemas.physics import CollisionShape, Contact, MassProperties, Solid, SurfaceMaterial
from sim.port import Simulator


@dataclass(frozen=True)
class Intake:
    """One object as read: the model in source units and axes, and the files it came from.

    `file_extent` is the bounding box of the whole file in source units: one file has one unit, however many objects.
    `folder` is the name of the file's folder: names may hold a unit. `folders` are the names of all folders from there
    up to the asset's root: they may name the category. `siblings` is the number of other objects in the file.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    format: str
    files: tuple[SourceFile, ...]
    model: Model
    file_extent: tuple[float, float, float]
    folder: str = ""
    folders: tuple[str, ...] = ()
    siblings: int = 0


@dataclass(frozen=True)
class IntakeResult:
    """The objects found in one source file, with findings and repairs; `review` when a person must look at it."""

    objects: tuple[Intake, ...]
    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    review: bool


@dataclass(frozen=True)
class Frame:
    """Scale and rotation that semantics gives an object; they replace those from the file alone, once.

    R_AS   (3, 3) rotation from the axes of the source to those of the asset.
    unit   metres per source unit, with findings; None keeps the unit of the file.
    front  the evidence for the front, which is +x of this frame; None while there is none.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    R_AS: FloatArray
    unit: UnitDecision | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    front: Front | None = None


@dataclass(frozen=True)
class LinkSurface:
    """The physical surface of one link of a mechanism, in the asset frame at rest; `wall` (m) of its sheets, if any."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    link: str
    solid: Solid
    wall: Evidence[float] | None = None


@dataclass(frozen=True)
class Retopology:
    """Meshes, materials and textures in place of the source's, in its units and axes; `section` where it was tried."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    meshes: tuple[Mesh, ...]
    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    section: RetopologySection | None = None


@dataclass(frozen=True)
class Canonical:
    """Repaired meshes in metres, z-up, bottom-centre origin, and the physical surface built from them.

    R_AS   (3, 3) rotation from the axes of the source to those of the asset.
    mechanism, links   how the links of an articulated object move, and the physical surface of each; `solid` is then
                       that of all at rest. None and () for a rigid object.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    meshes: tuple[Mesh, ...]
    solid: Solid
    meters_per_unit: Evidence[float]
    up_axis: Evidence[Axis]
    section: GeometrySection
    R_AS: FloatArray
    mechanism: Mechanism | None = None
    links: tuple[LinkSurface, ...] = ()


@dataclass(frozen=True)
class Appearance:
    """Materials and textures ready to be written; meshes refer to materials by index, and those to textures by name."""

    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    section: AppearanceSection


@dataclass(frozen=True)
class Semantics:
    """The semantics section of the object; `frame` where it changes the scale or the pose."""

    section: SemanticsSection
    frame: Frame | None = None


@dataclass(frozen=True)
class Interaction:
    """Parts of the object and its front; anchors are proposals until acceptance. `cavities` are the openings of the
    solid, for later stages. `material` is the material of the whole object, by names, use and surface appearance.
    `joint_uses` are those of an articulated object, without swept volumes; `link_cavities` the openings of the solids
    of its links by name, as far as they were looked for.
    """

    parts: tuple[Evidence[Part], ...] = ()
    material: Evidence[str] = field(default_factory=lambda: default("unknown"))
    anchors: tuple[Anchor, ...] = ()
    cavities: tuple[Cavity, ...] = ()
    front: Front | None = None
    joint_uses: tuple[JointUse, ...] = ()
    link_cavities: dict[str, tuple[Cavity, ...]] = field(default_factory=dict[str, tuple[Cavity, ...]])


@dataclass(frozen=True)
class Physics:
    """Collision shapes, mass properties and contact parameters.

    `surfaces` and `shape_surfaces` as in `schemas.package.PackageContent`. Of an articulated object `shapes` are those
    of all links at rest, `mass` that of all together, and `links` says what belongs to which; `swept` is what the
    links below each joint that moves on its own sweep, by the name of the joint.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    shapes: tuple[CollisionShape, ...]
    mass: MassProperties
    contact: Contact
    section: PhysicsSection
    surfaces: tuple[SurfaceMaterial, ...] = ()
    shape_surfaces: tuple[int, ...] = ()
    links: tuple[LinkBody, ...] = ()
    filtered_pairs: tuple[tuple[str, str], ...] = ()
    swept: dict[str, SweptVolume] = field(default_factory=dict[str, SweptVolume])


@dataclass(frozen=True)
class Recovery:
    """Materials with plausible values where the source states none that can be trusted, and the section on them.

    `mesh_materials` is the index of each mesh's material, in the order of the canonical meshes; -1 without one. Only
    pictures and packages show them: they are no evidence on the object.
    """

    materials: tuple[Material, ...]
    mesh_materials: tuple[int, ...]
    section: AppearanceSection


@dataclass(frozen=True)
class Previews:
    """PNG pictures by name; `thumbnail` is 256x256."""

    images: dict[str, bytes]


@dataclass(frozen=True)
class Acceptance:
    """Findings of simulator and validators on the package as re-read from disk.

    `anchors` are those that were verified; `affordances` the grasps, tried or not, rims and handles. `images` are PNG
    pictures by name: `grasps`, if there are some. `withdrawn_roles` are those that suites did not bear out.
    """

    section: AcceptanceSection
    anchors: tuple[Evidence[Anchor], ...] = ()
    affordances: tuple[AffordanceEvidence, ...] = ()
    images: dict[str, bytes] = field(default_factory=dict[str, bytes])
    withdrawn_roles: tuple[str, ...] = ()


StageResult = Retopology | Canonical | Appearance | Semantics | Interaction | Recovery | Physics | Previews | Acceptance
R = TypeVar("R", bound=StageResult)
# The field of a draft that holds a result of each type; it bears the name of the stage that makes it.
RESULT_FIELDS: dict[type[StageResult], str] = {
    Retopology: "retopology",
    Canonical: "canonicalize",
    Appearance: "appearance",
    Semantics: "semantics",
    Interaction: "interaction",
    Recovery: "recovery",
    Physics: "physics",
    Previews: "previews",
    Acceptance: "acceptance",
}


class MissingResult(LookupError):
    """A stage reads a result that the draft does not hold, or that the stage does not declare in `reads`."""


@dataclass(frozen=True)
class Edits:
    """What repairs change on a draft, see `assetkit.acceptance.repairs`.

    excluded_colliders  methods that may not make the colliders.
    tried_grasps        how many of the proposed grasps are tried at most; 0: as many as usual.
    friction_gain       factor on friction that was inferred, within its bounds.
    """

    excluded_colliders: tuple[str, ...] = ()
    tried_grasps: int = 0
    friction_gain: float = 1.0


@dataclass(frozen=True)
class Draft:
    """One asset in the pipeline. Each field is the result of the stage of that name, None until it has run.

    `draft[Physics]` is the result of that type; it raises MissingResult while there is none.
    """

    asset_id: str
    source_name: str
    intake: Intake
    retopology: Retopology | None = None
    canonicalize: Canonical | None = None
    appearance: Appearance | None = None
    semantics: Semantics | None = None
    interaction: Interaction | None = None
    recovery: Recovery | None = None
    physics: Physics | None = None
    previews: Previews | None = None
    acceptance: Acceptance | None = None
    edits: Edits = field(default_factory=Edits)
    frame: Frame | None = None

    def __getitem__(self, result: type[R]) -> R:
        value: object = getattr(self, RESULT_FIELDS[result])
        if not isinstance(value, result):
            raise MissingResult(f"the draft of '{self.asset_id}' holds no {result.__name__} here")
        return value

    def with_result(self, value: StageResult) -> Draft:
        """The draft with the result of one stage."""
        return replace(self, **{RESULT_FIELDS[type(value)]: value})

    def limited_to(self, reads: tuple[type[StageResult], ...]) -> Draft:
        """The draft as a stage may see it: without the results that it does not read."""
        return replace(self, **{name: None for result, name in RESULT_FIELDS.items() if result not in reads})

    @property
    def item(self) -> Intake:
        """The object to make canonical: as read, with the light meshes of retopology where there are some."""
        light = self.retopology
        if light is None:
            return self.intake
        model = replace(self.intake.model, meshes=light.meshes, materials=light.materials, textures=light.textures)
        return replace(self.intake, model=model)

    @property
    def model(self) -> Model:
        """The model as far as it has come: canonical meshes and final materials where they exist."""
        source = self.item.model
        meshes = self.canonicalize.meshes if self.canonicalize else source.meshes
        materials = self.appearance.materials if self.appearance else source.materials
        if self.recovery is not None:
            pairs = zip(meshes, self.recovery.mesh_materials, strict=True)
            meshes = tuple(replace(mesh, material=index if index >= 0 else None) for mesh, index in pairs)
            materials = self.recovery.materials
        return Model(
            meshes=meshes,
            materials=materials,
            textures=self.appearance.textures if self.appearance else source.textures,
            nodes=source.nodes,
            meters_per_unit=source.meters_per_unit,
            up_axis=source.up_axis,
            hints=source.hints,
            metadata=source.metadata,
            mechanism=self.canonicalize.mechanism if self.canonicalize else source.mechanism,
        )


@dataclass(frozen=True)
class Tools:
    """Resources of the stages: the simulator, a scratch folder, the user's options, a store of models' answers.

    With `endpoint_lost` the endpoint was out of reach for another object of the file and is left alone. `mark` is a
    file beside the scratch folder; results are stored only while it exists. `last_package` remembers the package that
    lies in the scratch folder.
    """

    simulator: Simulator
    work_dir: Path
    options: Options
    answers: Cache | None = None
    endpoint_lost: bool = False
    mark: Path | None = None
    last_package: LastPackage = field(default_factory=LastPackage)


class Stage(Protocol):
    """One step. `version` is bumped whenever the output for the same input may change.

    `reads` are the types of the earlier results that it uses; it sees no others.
    """

    name: str
    version: int
    result: type[StageResult]
    reads: tuple[type[StageResult], ...] = ()

    def accepts(self, draft: Draft) -> list[Diagnostic]:
        """Cheap findings that forbid running; none unless a stage overrides this. No side effects."""
        return []

    def wanted(self, options: Options) -> bool:
        """Whether the stage runs at all; always unless a stage overrides this."""
        return True

    def run(self, draft: Draft, tools: Tools) -> Outcome[StageResult]:
        """The stage's result, an instance of `result`."""
        ...
