"""The protocol of a suite, what it exercises (`Subject`), under which `Conditions`, and what it gives (`SuiteRun`).

All lengths in metres, frame of the asset; everything was re-read from the bytes of a package.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

from assetkit.acceptance.suites.policy import POLICY
from schemas.acceptance import Check, StablePose
from schemas.affordances import Grasp, Region
from schemas.anchors import Anchor
from schemas.articulation import JointUse
from schemas.asset import Role
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.physics import Contact, MassProperties, RigidBody
from sim.grasp_trial import GraspTrace
from sim.joint_handling import HandlingTrace
from sim.port import Simulator
from usdio.reread.body import RereadPackage

DEFAULT_STEP_S = 1.0 / 240.0  # of the engine


@dataclass(frozen=True)
class Conditions:
    """At which friction of the object's own surface, mass and engine step a suite runs; None: those of the package."""

    name: str = "nominal"
    friction: float | None = None
    mass_kg: float | None = None
    step_s: float = DEFAULT_STEP_S


NOMINAL = Conditions()


@dataclass(frozen=True)
class Subject:
    """A package as suites see it.

    content    its bodies and joints as the USD holds them.
    roles      that it promises, the first one first.
    poses      stable poses, the most probable first.
    grasps, regions, anchors, joint_uses  as recorded; empty where nothing is on record.
    most_grasps  that are tried before it counts as one that cannot be held.
    friction_bounds, mass_bounds_kg  between which values are believed to lie; None where nothing is on record.
    findings   of reading it: what was converted or assumed in a package without a record.
    """

    main_file: Path
    content: RereadPackage
    roles: tuple[Role, ...] = ()
    poses: tuple[StablePose, ...] = ()
    grasps: tuple[Grasp, ...] = ()
    regions: tuple[Region, ...] = ()
    anchors: tuple[Anchor, ...] = ()
    joint_uses: tuple[JointUse, ...] = ()
    most_grasps: int = POLICY.tries
    friction_bounds: tuple[float, float] | None = None
    mass_bounds_kg: tuple[float, float] | None = None
    findings: tuple[Diagnostic, ...] = ()

    @property
    def body(self) -> RigidBody:
        """The object as one body; an articulated one with its joints held at rest."""
        return self.content.body

    @property
    def is_articulated(self) -> bool:
        """Whether it has joints."""
        return self.content.mechanism is not None

    def under(self, conditions: Conditions) -> Subject:
        """The subject with the friction and mass of the conditions; mass is added evenly, so inertia grows with it."""
        body = self.content.body
        if conditions.friction is not None:
            body = replace(body, contact=_with_friction(body.contact, conditions.friction))
        if conditions.mass_kg is not None:
            body = replace(body, mass=_scaled(body.mass, conditions.mass_kg / body.mass.mass_kg))
        return self if body is self.content.body else replace(self, content=replace(self.content, body=body))


def _with_friction(contact: Contact, friction: float) -> Contact:
    ratio = contact.static_friction / contact.dynamic_friction if contact.dynamic_friction > 0.0 else 1.0
    return contact.model_copy(update={"dynamic_friction": friction, "static_friction": friction * ratio})


def _scaled(mass: MassProperties, ratio: float) -> MassProperties:
    return MassProperties(mass.mass_kg * ratio, mass.centre_of_mass_m, mass.inertia_kgm2 * ratio)


@dataclass(frozen=True)
class SuiteRun:
    """What a suite measured: its checks, a finding per kind of failed check, and a motion to look at, if there is one.

    `tried` is the subject with nothing but what the checks are about, as the one grasp of several that was best: it is
    what the suite runs on under other conditions. None where that is the whole subject.
    """

    checks: tuple[Check, ...]
    findings: tuple[Diagnostic, ...] = ()
    tried: Subject | None = None
    trace: GraspTrace | None = None
    handled: tuple[HandlingTrace, ...] = ()

    @property
    def passes(self) -> bool:
        """Whether every check passes."""
        return all(check.passed for check in self.checks)


class Suite(Protocol):
    """Exercises in simulation what a role promises."""

    @property
    def name(self) -> str:
        """One word, as `--suite` takes it."""
        ...

    @property
    def roles(self) -> frozenset[Role]:
        """Roles that the suite is for; empty: for every object."""
        ...

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings that it may give."""
        ...

    @property
    def varies(self) -> bool:
        """Whether friction and mass matter to it, so that it also runs at other values of them."""
        ...

    def obstacle(self, subject: Subject) -> str:
        """Why the suite cannot be run on the subject, in words; "" where it can."""
        ...

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """The suite on a subject at the given conditions. `obstacle` is "" for it. Equal calls give equal results."""
        ...


def at_most(name: str, value: float, bound: float, unit: str) -> Check:
    """A figure that must not exceed its bound; NaN does not pass."""
    return Check(name=name, value=float(value), bound=float(bound), unit=unit, passed=bool(value <= bound))


def at_least(name: str, value: float, bound: float, unit: str) -> Check:
    """A figure that must reach its bound; NaN does not pass."""
    return Check(name=name, value=float(value), bound=float(bound), unit=unit, passed=bool(value >= bound))


@dataclass
class CheckList:
    """Checks in order with the code of the finding that each failure is; the first failure of a code names it."""

    where: Location
    checks: list[Check] = field(default_factory=list[Check])
    findings: list[Diagnostic] = field(default_factory=list[Diagnostic])

    def add(self, code: str, headline: str, check: Check) -> None:
        """Add a check; if it fails and the code is not among the findings yet, a finding with that headline."""
        self.checks.append(check)
        if check.passed or any(f.code == code for f in self.findings):
            return
        figures = {"value": check.value, "bound": check.bound, "unit": check.unit}
        self.findings.append(finding(code, headline, where=self.where, **figures))

    def run(
        self,
        tried: Subject | None = None,
        trace: GraspTrace | None = None,
        handled: Sequence[HandlingTrace] = (),
    ) -> SuiteRun:
        """The result."""
        return SuiteRun(tuple(self.checks), tuple(self.findings), tried, trace, tuple(handled))


def prefixed(checks: Sequence[Check], prefix: str) -> tuple[Check, ...]:
    """The checks with a prefix to their names."""
    return tuple(check.model_copy(update={"name": f"{prefix}/{check.name}"}) for check in checks)
