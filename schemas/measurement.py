"""`measurement.yaml`: the recorded columns and the current model of robot or body (design: sim gap contract).

SI units; quaternions wxyz; `inertia_kgm2` about the mass centre in body axes. Hand-written: unknown keys are errors,
and angles may be in degrees under a key that ends in `_deg` (`zero_deg` for `zero_rad`, `limits_deg` for `limits`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, cast

from pydantic import BaseModel, ConfigDict, Field, model_validator

from schemas.asset import Vec3
from schemas.physical_constants import GRAVITY_MPS2

Kind = Literal["free_body", "mechanism", "tracking", "impact", "push"]
KINDS: tuple[Kind, ...] = ("free_body", "mechanism", "tracking", "impact", "push")
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]


class Strict(BaseModel):
    """A hand-written node: an unknown key is an error."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        coerce_numbers_to_str=True,
        json_schema_extra=lambda schema: _allow_degrees(schema),
    )

    @model_validator(mode="before")
    @classmethod
    def _degrees(cls, data: Any) -> Any:
        """Keys in degrees become the field in radians; a text is left for the field to refuse."""
        if not isinstance(data, dict):
            return data
        given: dict[Any, Any] = {}
        for key, value in cast(dict[Any, Any], data).items():
            stem = str(key).removesuffix("_deg")
            field = next((f for f in (f"{stem}_rad", stem) if f in cls.model_fields and f in _ANGLES), None)
            if stem == key or field is None:
                given[key] = value
            elif field in data:
                raise ValueError(f"both {key} and {field} are given")
            else:
                given[field] = _radians(value)
        return given


_ANGLES = ("zero_rad", "rotation_rad", "limits")


def _allow_degrees(schema: dict[str, Any]) -> None:
    """Adds the keys in degrees to the JSON Schema."""
    properties: dict[str, Any] = schema.get("properties", {})
    for name in [n for n in properties if n in _ANGLES]:
        twin = {k: v for k, v in properties[name].items() if k not in ("default", "title")}
        properties[f"{name.removesuffix('_rad')}_deg"] = twin


def _radians(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_radians(v) for v in cast(Sequence[Any], value)]
    return math.radians(value) if isinstance(value, int | float) else value


class Box(Strict):
    """Full edge lengths."""

    size_m: tuple[Positive, Positive, Positive]


class PairContact(Strict):
    """Coefficients of the pair body-support; further keys are contact effects of the library, which the reader checks.

    Such a key is the effect's name after `contact.`; its value is the effect's one parameter, or a mapping of all, e.g.
    `rolling_friction: 0.002` or `compliance: {stiffness_Npm: 2.0e+4, damping_Nspm: 15}`.
    """

    model_config = ConfigDict(extra="allow")

    friction: NonNegative = 0.5
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0

    @property
    def effects(self) -> dict[str, Any]:
        """What is given besides friction and restitution: numbers, or mappings of names to numbers."""
        return self.model_extra or {}


class GravityLoad(Strict):
    """A mass hanging on a joint; at joint angle `zero_rad` it hangs straight down."""

    mass_kg: Positive
    com_distance_m: NonNegative
    zero_rad: float = 0.0

    @property
    def inertia_kgm2(self) -> float:
        """About the joint's axis, of the mass as a point: the least that a joint with this load can have."""
        return self.mass_kg * self.com_distance_m**2


class Joint(Strict):
    """One joint of a mechanism, base to tip; `inertia_kgm2` is the total about its axis, load included.

    Without it the load counts as a point mass.
    """

    name: str
    type: Literal["revolute", "prismatic"] = "revolute"
    inertia_kgm2: Positive | None = None
    mass_kg: Positive | None = None
    gravity_load: GravityLoad | None = None
    limits: tuple[float, float] | None = None
    damping: NonNegative = 0.0  # viscous, N s/m or N m s/rad
    friction: NonNegative = 0.0  # Coulomb, N or N m
    parent_offset_m: float = 0.0  # along the parent link, from the parent's axis


class Controller(Strict):
    """The robot's controller as its owner describes it (kind `tracking`)."""

    type: Literal["stable_pd"]
    kp: float | tuple[float, ...]
    kd: float | tuple[float, ...]


class Subject(Strict):
    """The thing that moved. One of `box`, `mesh`, `urdf`, `package`, `joints`; paths stay inside the folder."""

    box: Box | None = None
    mesh: str | None = None
    urdf: str | None = None
    package: str | None = None
    joints: tuple[Joint, ...] = ()
    mass_kg: Positive | None = None
    inertia_kgm2: tuple[Positive, Positive, Positive] | None = None
    com_m: Vec3 = (0.0, 0.0, 0.0)
    contact: PairContact = PairContact()
    base_pose: tuple[float, ...] | None = None
    end_effector: str | None = None
    controller: Controller | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Subject:
        given = [k for k in ("box", "mesh", "urdf", "package", "joints") if getattr(self, k)]
        if len(given) > 1:
            raise ValueError(f"give one of box, mesh, urdf, package, joints; found {' and '.join(given)}")
        return self


class Plane(Strict):
    """The half-space below it is solid."""

    normal: Vec3 = (0.0, 0.0, 1.0)
    height_m: float = 0.0


class Support(Strict):
    """What the body lands on."""

    plane: Plane = Plane()


class WorldModel(Strict):
    """Gravity and the support; no `support` means free space."""

    gravity_mps2: Vec3 = (0.0, 0.0, -GRAVITY_MPS2)
    support: Support | None = None


class SimulatorSettings(Strict):
    """How its owner simulates the model: a fixed step; PyBullet's own by default."""

    step_s: Positive = 1.0 / 240.0


class Actuation(Strict):
    """What drives the joints: nothing, a known effort, or a position controller."""

    type: Literal["none", "effort", "position_pd"] = "none"
    kp: NonNegative | tuple[NonNegative, ...] = 0.0
    kd: NonNegative | tuple[NonNegative, ...] = 0.0
    effort_limit: Positive | None = None
    effort_per_unit: float = 1.0  # N or N m per unit of the effort column


class SensorNoise(Strict):
    """One standard deviation of each measured quantity; estimated where absent."""

    p_m: Positive | None = None
    rotation_rad: Positive | None = None
    v_mps: Positive | None = None
    w_radps: Positive | None = None
    q: Positive | None = None  # rad or m
    qd: Positive | None = None


class TrialSplit(Strict):
    """Trial ids; never a part of a trial."""

    train: tuple[str, ...]
    test: tuple[str, ...]


class MeasurementSpec(Strict):
    """The whole file. `columns` and `aux` map our name to the file's column(s)."""

    schema_version: Literal[1]
    name: str
    kind: Kind
    description: str = ""
    source: str = ""
    licence: str = ""
    rate_hz: Positive | None = None
    columns: dict[str, str | tuple[str, ...]] = {}
    aux: dict[str, str] = {}
    sensor_noise: SensorNoise = SensorNoise()
    subject: Subject
    world: WorldModel = WorldModel()
    simulator: SimulatorSettings = SimulatorSettings()
    actuation: Actuation = Actuation()
    split: TrialSplit | None = None
