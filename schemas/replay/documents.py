"""The file `variant.json` that replay augmentation writes beside a recording, one for every variant.

Frames: W world of the recording, z up; A asset frame of an inserted object. Metres, quaternions wxyz.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from schemas.scene.compiled import Point3, Quat_wxyz
from schemas.scene.program import Inline, PairedMaterial

SCHEMA_VERSION = "1.0"
VARIANT_FILE = "variant.json"


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class Inserted(_Model):
    """One object that was put in and never moves: a released package, or a `primitive` as written before `scale`.

    `package` is its folder below the folder of packages, `package_hash` the SHA-256 of its record. `stance` names its
    resting orientation, `support` the shape of a fixture under it. `material` is the one that the plan drew, by
    name; empty where the asset keeps its own.
    """

    name: str
    asset_id: str
    position_m: Point3
    quat_wxyz: Quat_wxyz
    support: str
    stance: str = ""
    package: str | None = None
    package_hash: str | None = None
    scale: float = 1.0
    primitive: Annotated[Inline, Field(discriminator="type")] | None = None
    mass_kg: float | None = None
    material: str = ""


class Variant(_Model):
    """One recording with new static objects, and everything that is needed to make it again.

    `source` is the recording as the user named it, `part` what holds it in there, `recording` its copy beside this
    file, `scene` and `meshes` what was named to read it with, `source_sha256` the digests of its streams by name.
    `materials` are those that inserted objects name, as their plan states them; `lights` the lighting as drawn.
    `camera_hidden` is the share of task-object pixels that the inserted objects newly hide, by camera; empty where
    it was not computed or none is seen. `taken_out` counts objects that had a place but hid more than was allowed.
    `feasible_area_m2` is the area free of motion and obstacles up to 10 cm, by support.
    """

    schema_version: str = SCHEMA_VERSION
    episode: str
    source: str
    part: str = ""
    recording: str = ""
    scene: str = ""
    meshes: str = ""
    source_sha256: dict[str, str] = {}
    seed: int
    number: int
    clearance_m: float
    objects_requested: int
    inserted: tuple[Inserted, ...]
    materials: dict[str, PairedMaterial] = {}
    lights: dict[str, float | str] = {}
    feasible_area_m2: dict[str, float] = {}
    camera_hidden: dict[str, float] = {}
    taken_out: int = 0
    provenance: dict[str, str] = {}


class Near(_Model):
    """Two bodies and the least distance between them; `t_s` where one of them moves in the recording."""

    inserted: str
    other: str
    distance_m: float
    t_s: float | None = None


class Moved(_Model):
    """How far an inserted object went when everything was let go."""

    name: str
    moved_m: float
    turned_deg: float
    stayed: bool


class VariantCheck(_Model):
    """What verification found of one variant. `near` are all pairs under the clearance; `nearest` the nearest of all.

    `contacts` counts pairs that touch. `nearest` is None without a pair. `moved` is empty where nothing was
    let go. `states_identical`: every stream of the copy has the digest of the source. `link_error_m`, `link_error_deg`:
    how far the model's links are at most from recorded link poses, None where none were recorded. `notes` are warnings
    about the recording.
    """

    variant: str
    objects_requested: int
    objects_inserted: int
    contacts: int
    clearance_m: float
    clearance_violations: int
    nearest: Near | None
    near: tuple[Near, ...] = ()
    moved: tuple[Moved, ...] = ()
    states_identical: bool
    feasible_area_m2: float | None = None
    newly_hidden_fraction: float | None = None
    link_error_m: float | None = None
    link_error_deg: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def sound(self) -> bool:
        """No contact, no violation, nothing moved, states identical."""
        return not self.near and self.states_identical and all(m.stayed for m in self.moved)
