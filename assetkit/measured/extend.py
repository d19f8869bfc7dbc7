"""Writes measured physics into a copy of a released package (USD, URDF, record), validates and publishes it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from assetkit.acceptance.judge_package import PackageVerdict, judge_package
from assetkit.affordances.grasp_trials import without_trial
from assetkit.measured.extend_record import extended_section
from assetkit.package.package import AddExtension, Package, RewritePhysics, WriteRecord
from assetkit.package.record import RECORD, read_record
from assetkit.package.release import publish
from jobs.cache import content_key
from schemas.asset import AssetRecord, PhysicsSection, StageEntry
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.measured_physics import MeasuredPhysics
from schemas.outcome import ItemOutcome
from schemas.physics import MassProperties
from sim.port import Simulator

NAME, VERSION = "extend", 1
# Findings of acceptance; they are replaced by those of the extended package.
_ACCEPTANCE_CODES = (
    "asset/gate-",
    "asset/package-invalid",
    "asset/render-collision-misaligned",
    "asset/unstable-settling",
    "asset/reference-pose-topples",
    "asset/no-stable-pose",
)


@dataclass(frozen=True)
class ExtensionResult:
    """The new package (None when acceptance rejects it), its record, and the findings of acceptance."""

    package: Path | None
    record: AssetRecord
    diagnostics: tuple[Diagnostic, ...]


def record_of(package: Path) -> AssetRecord:
    """The record of a package that can be extended. Raises InvalidInput (`asset/package-invalid`)."""
    record = read_record(package)
    if record is None:
        raise InvalidInput(finding("asset/package-invalid", f"'{package.name}' is no package of Mana"))
    missing = [p for p in (main_file_of(package, record), _urdf_file(package, record)) if not p.is_file()]
    if missing:
        raise InvalidInput(finding("asset/package-invalid", f"'{package.name}' has no {missing[0].name}"))
    return record


def extend_package(package: Path, measured: MeasuredPhysics, out: Path, simulator: Simulator) -> ExtensionResult:
    """Publish `<out>/<asset_id>`: the package with `measured` in USD, URDF twin and record, judged like any other.

    It is prepared beside its target and moved there in one step; a package that fails acceptance is not published, and
    what was there stays. `out` may be the folder that holds `package`: then it is replaced.
    """
    record = record_of(package)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out, prefix=".extend") as place:
        folder = Path(place) / record.asset_id
        shutil.copytree(package, folder)
        (folder / RECORD).unlink()
        section = extended_section(record.physics, measured)
        mass = MassProperties(
            section.mass_kg.value, np.array(section.centre_of_mass_m.value), np.array(section.inertia_kgm2.value)
        )
        contact = section.contacts[0].value
        changed = contact if contact != record.physics.contacts[0].value else None
        density_factor = section.density_kgm3.value / record.physics.density_kgm3.value
        made = Package.on_disk(folder).edited(RewritePhysics(mass, changed, density_factor, measured.urdf_contact))
        made = made.edited(AddExtension(measured.extension_json))
        verdict = judge_package(
            made.main_file, simulator, record.geometry.extent_m.value, record.physics.collider_misses_bounds
        )
        extended = _record(record, section, verdict, measured, made.hashes)
        made.edited(WriteRecord(extended))
        occupied = None if extended.outcome is ItemOutcome.REJECTED else publish(folder, out / record.asset_id)
    diagnostics = (*verdict.diagnostics, *((occupied,) if occupied else ()))
    refused = occupied is not None or extended.outcome is ItemOutcome.REJECTED
    return ExtensionResult(None if refused else out / record.asset_id, extended, diagnostics)


def _record(
    record: AssetRecord,
    section: PhysicsSection,
    verdict: PackageVerdict,
    measured: MeasuredPhysics,
    hashes: Mapping[str, str],
) -> AssetRecord:
    """The old record with the new physics, verdict, history and hashes; an object under review stays under review."""
    outcome = ItemOutcome.REVIEW if verdict.review else record.outcome
    if any(d.severity is Severity.ERROR for d in verdict.diagnostics):
        outcome = ItemOutcome.REJECTED
    key = content_key(NAME, VERSION, [e.key for e in record.history], measured.extension_json.decode())
    earlier = tuple(d for d in record.diagnostics if not d.code.startswith(_ACCEPTANCE_CODES))
    return record.model_copy(
        update={
            "outcome": outcome,
            "physics": section,
            "acceptance": verdict.section,
            "affordances": tuple(without_trial(e) for e in record.affordances),
            "diagnostics": (*earlier, *verdict.diagnostics),
            "history": (*record.history, StageEntry(name=NAME, version=VERSION, key=key[:16])),
            "hashes": dict(hashes),
        }
    )


def main_file_of(package: Path, record: AssetRecord) -> Path:
    """Where the main USD file of a package lies."""
    return package / "usd" / f"{record.asset_id}.usda"


def _urdf_file(package: Path, record: AssetRecord) -> Path:
    return package / "export" / f"{record.asset_id}.urdf"
