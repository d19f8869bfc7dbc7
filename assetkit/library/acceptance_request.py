"""What `mana assets accept` hands to its cell, and what comes back, as JSON files."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from schemas.acceptance import SuiteSection
from schemas.asset import Role
from schemas.diagnostics import Diagnostic, Severity

GATE = "gate"  # the static rules of docs/reference/gate.md
OBJECT = "object"  # what is measured of every object: frame, colliders, mass, settling, stable poses, joints
ON_RECORD = "on_record"  # what a record says of the object, tried on the files again


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, ser_json_inf_nan="strings")


class AcceptanceRequest(_Model):
    """One package and what to run on it.

    engine    names the simulator (`sim.named_engine`).
    suites    by name; empty: those of the roles.
    roles     in place of those on record; of a package without a record of Mana, its roles.
    thorough  also at other steps, and at the ends of the bounds of friction and mass.
    video     where to write a GIF of what the suites did; "" for none.
    """

    main_file: str
    engine: str
    suites: tuple[str, ...] = ()
    roles: tuple[Role, ...] = ()
    thorough: bool = True
    video: str = ""


class AcceptanceReport(_Model):
    """What the suites found on one package; `video` is the GIF that was written, "" where nothing moved."""

    roles: tuple[Role, ...] = ()
    suites: tuple[SuiteSection, ...] = ()
    findings: tuple[Diagnostic, ...] = ()
    video: str = ""

    @property
    def passed(self) -> bool:
        """Whether no suite failed and nothing is wrong with the file."""
        failed = any(suite.outcome == "failed" for suite in self.suites)
        return not failed and not any(f.severity is Severity.ERROR for f in self.findings)
