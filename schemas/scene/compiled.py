"""Results of the scene compiler: a verdict, with a whole scene (W, metres, z up) or none."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.diagnostics import Diagnostic, Location
from schemas.scene.geometry import Prism
from schemas.scene.program import Inline

SCHEMA_VERSION = "1.0"
Verdict = Literal["compiled", "infeasible", "budget_exhausted", "invalid_program"]
Point2 = tuple[float, float]
Point3 = tuple[float, float, float]
Quat_wxyz = tuple[float, float, float, float]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class PlacedObject(_Model):
    """One object at rest. `position_m` and `quat_wxyz` are those of its asset frame in the world.

    `prisms` are its collision geometry in the world, by which anyone can check the scene without packages. `parent` is
    the object under or around it (`background` for fixed objects), `anchor` the name of that place. `package` is
    its folder below `packages/` beside the scene file; what has none is the `primitive` as written, before `scale`.
    `mass_kg` is the mass at that scale, None where nobody said any. `joints` are the positions (m, rad) of the joints
    of an articulated object, for which the prisms hold; other objects have no such key.
    """

    id: str
    asset_id: str
    package: str | None
    position_m: Point3
    quat_wxyz: Quat_wxyz
    scale: float
    parent: str
    anchor: str
    prisms: tuple[Prism, ...]
    semantic_tags: tuple[str, ...] = ()
    primitive: Annotated[Inline, Field(discriminator="type")] | None = None
    mass_kg: float | None = None
    joints: dict[str, float] = Field(default={}, exclude_if=lambda joints: not joints)


class ClearedSpace(_Model):
    """Space in the world that a joint of an object sweeps and that other objects leave free (`keep_clear`)."""

    owner: str
    joint: str
    prisms: tuple[Prism, ...]


class CompiledScene(_Model):
    """A complete, checked scene in the world frame: metres, z up. Never partial."""

    schema_version: str = SCHEMA_VERSION
    scene: str
    seed: int
    combination: dict[str, str] = {}
    background: PlacedObject | None
    objects: tuple[PlacedObject, ...]
    clearance_m: float
    keep_clear: tuple[ClearedSpace, ...] = Field(default=(), exclude_if=lambda spaces: not spaces)


class ConflictMember(_Model):
    """One authored constraint that cannot hold together with the others."""

    path: str
    file: str | None = None
    line: int | None = None
    column: int | None = None


class Suggestion(_Model):
    """A change of the program; `verified` when it was compiled again and gave a scene."""

    edit: str
    verified: bool


class CombinationVerdict(_Model):
    """What became of one combination of geometry-changing variants; `scene` is its stage, beside the report."""

    combination: dict[str, str]
    verdict: Verdict
    proof: str = ""
    seconds: float = 0.0
    scene: str | None = None


class ComponentVerdict(_Model):
    """Things that share nothing with the others whatever the variants choose, with a verdict for each combination of
    only the variants that reach them; the worst is that of the component. Objects in `union` were tried with all their
    candidates at once, because single ones would be more than 256; rows that name one of these tried that one alone.
    """

    things: tuple[str, ...]
    verdict: Verdict
    combinations: tuple[CombinationVerdict, ...]
    union: tuple[str, ...] = ()


class Settling(_Model):
    """How far one object went from its compiled pose when everything was let go at once."""

    id: str
    moved_m: float
    turned_rad: float
    stayed: bool


class CompileReport(_Model):
    """`mana scene compile --json` and `diagnose --json` (design: JSON that outside tools rely on)."""

    schema_version: str = SCHEMA_VERSION
    verdict: Verdict
    seconds: float
    matrix: tuple[CombinationVerdict, ...] = Field(
        default=(), description="of whole scenes: all combinations up to 256, else those that were written"
    )
    components: tuple[ComponentVerdict, ...] = Field(default=(), description="what is decided apart from the rest")
    combinations: int = Field(default=0, description="of all variants together, however many rows `matrix` has")
    diagnostics: tuple[Diagnostic, ...] = ()
    conflict: tuple[ConflictMember, ...] = ()
    minimal: bool | None = None
    proof: str = ""
    blocking: str | None = None
    suggestions: tuple[Suggestion, ...] = ()
    scene: str | None = None
    plan: str | None = None
    phases: dict[str, float] = Field(default={}, description="seconds of each phase, in the order they ran")
    settling: tuple[Settling, ...] = Field(default=(), description="of `scene`; empty when it was not let go")


def location_of(member: ConflictMember) -> Location:
    """Position of a member in the text."""
    return Location(file=member.file, line=member.line, column=member.column)
