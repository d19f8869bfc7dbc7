"""Verdict on a package on disk, from external validators, the static gate and the simulator: the acceptance section.

An error that only a person can decide becomes a warning and marks the asset for review.
"""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path

from assetkit.acceptance.judge_body import AcceptanceResult, accept
from assetkit.package.package import Package, reread
from gate.external_validators import ValidatorIssue, external_verdicts
from gate.static_gate import gate
from schemas.acceptance import AcceptanceSection, Check
from schemas.asset import Vec3
from schemas.diagnostics import Diagnostic, Location, Severity, finding
from sim.port import Simulator
from usdio.reread.body import RereadPackage

# Either the unit of the source or its category is wrong, or the object is a toy: a person must decide.
UNDECIDED = frozenset({"asset/gate-category-size"})

# Gate findings that are expected of a stand-in collider, which is recorded to miss its bounds.
OF_STAND_INS = frozenset({"asset/gate-collider-astray", "asset/gate-collider-displaced"})


def require_files(package: Package) -> None:
    """Raises FileNotFoundError for the first file that is missing: a verdict would not be about the whole package."""
    for name in package.hashes:
        if not (package.folder / name).is_file():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(package.folder / name))


@dataclass(frozen=True)
class PackageVerdict:
    """The acceptance section of the record, findings, and whether a person should review the package."""

    section: AcceptanceSection
    diagnostics: tuple[Diagnostic, ...]
    review: bool


def judge_package(
    main_file: Path, simulator: Simulator, extent_m: Vec3, collider_misses_bounds: bool = False
) -> PackageVerdict:
    """Verdict of external validators, gate and simulator on the package with this main file, as it is on disk.

    `stands_in`: the collider is a stand-in that misses its bounds, so that a person reviews the package anyway.
    """
    simulated = simulate_package(main_file, reread(main_file), simulator, extent_m)
    return judge_bytes(main_file, simulated, collider_misses_bounds)


def simulate_package(main_file: Path, content: RereadPackage, simulator: Simulator, extent_m: Vec3) -> AcceptanceResult:
    """Acceptance of the body of a package, whose `content` was re-read from disk, in the simulator."""
    visual = content.visual_points, content.visual_triangles
    return accept(main_file, simulator, body=content.body, visual=visual, extent_m=extent_m, links=content.links)


def judge_bytes(main_file: Path, simulated: AcceptanceResult, collider_misses_bounds: bool) -> PackageVerdict:
    """Verdict of external validators and gate on the files of a package, combined with the simulated acceptance."""
    verdicts = external_verdicts(main_file)
    judged_by_gate = gate(main_file)
    review = any(d.code in UNDECIDED and d.severity is Severity.ERROR for d in judged_by_gate)
    known = UNDECIDED | (OF_STAND_INS if collider_misses_bounds else frozenset())
    gate_findings = tuple(_for_a_person(d, known) for d in judged_by_gate)
    errors = [d for d in gate_findings if d.severity is Severity.ERROR]
    validators = tuple(_check(v.validator, len(v.findings)) for v in verdicts)
    validators += (_check("mana gate", len(errors)),)
    section = simulated.section.model_copy(update={"validators": validators})
    refused = tuple(_refused(v.validator, v.findings) for v in verdicts if not v.passed)
    return PackageVerdict(section, (*refused, *gate_findings, *simulated.diagnostics), review)


def _for_a_person(diagnostic: Diagnostic, known: frozenset[str]) -> Diagnostic:
    """The finding, as a warning if only a person can decide it: it does not reject the package then."""
    undecided = diagnostic.code in known
    return diagnostic.model_copy(update={"severity": Severity.WARNING}) if undecided else diagnostic


def _check(name: str, errors: int) -> Check:
    return Check(name=name, value=errors, bound=0, unit="errors", passed=errors == 0)


def _refused(name: str, remarks: tuple[ValidatorIssue, ...]) -> Diagnostic:
    return finding(
        "asset/package-invalid",
        f"{name} refuses the package: {remarks[0]}",
        where=Location(prim=remarks[0].prim or None),
        value=len(remarks),
        bound=0,
        unit="errors",
    )
