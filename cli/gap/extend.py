"""The work of `mana gap extend`: measured numbers into the files of an asset, and what they cannot hold."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from assetkit.library import catalog
from assetkit.measured.extend import extend_package, main_file_of, record_of
from assetkit.measured.extend_urdf import extend_urdf
from assetkit.package.package import EXTENSION
from geom.convex.support_function import bounds
from jobs.cache import write_atomically
from jobs.lock import exclusive
from schemas.asset import AssetRecord
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.sim_gap.extension import ModelExtension
from simgap.extension.exportable import MeasuredBody, Row, joint_physics, package_physics, refuse_impossible
from simgap.extension.extension import read_extension, terms_of
from simgap.kinds.free_body.declared_model import build_body
from simgap.recording.read import read

_SAME_SIZE = 0.02  # of the extent: the measured body is the one in the package
_NO_FRAME = "it is relative to the body as measured: give --measurement"
_TWICE = "it is relative to the package as it was measured, and this one was extended before"


@dataclass(frozen=True)
class Answer:
    """Where the result lies (None: refused by acceptance), what was written, what stays in extension.json."""

    path: Path | None
    rows: tuple[Row, ...]
    diagnostics: tuple[Diagnostic, ...] = ()

    def data(self) -> dict[str, Any]:
        """As JSON-serialisable values."""
        return {
            "path": None if self.path is None else str(self.path),
            "written": [_row(r) for r in self.rows if r.written],
            "only_in_extension_json": [_row(r) for r in self.rows if not r.written],
            "diagnostics": [d.model_dump(mode="json") for d in self.diagnostics],
        }


def extend(target: Path, extension_file: Path, measurement: Path | None, out: Path | None) -> Answer:
    """Extend a package folder or a URDF file; `out` None replaces it.

    Raises InvalidInput for an extension, package, URDF or measurement that cannot be used, and FolderInUse while
    another command, such as `mana assets ingest`, writes into the folder of the new package.
    """
    extension = read_extension(extension_file)
    terms_of(extension)  # Refuses unknown effects and parameters.
    refuse_impossible(extension)
    if target.suffix.lower() == ".urdf":
        return _urdf(target, extension, extension_file.read_bytes(), out)
    folder = out or target.absolute().parent
    with exclusive(folder):
        return _package(target, extension, extension_file.read_bytes(), measurement, folder)


def _package(target: Path, extension: ModelExtension, given: bytes, measurement: Path | None, folder: Path) -> Answer:
    record = record_of(target)
    body, reason = _body(target, record, extension, measurement)
    physics, rows = package_physics(extension, given, record.physics, body, reason)
    from sim.bullet.simulator import BulletSimulator  # Loads the engine.

    with BulletSimulator() as simulator:
        extended = extend_package(target, physics, folder, simulator)
    if extended.package is not None and (folder / catalog.CATALOG).is_file():
        catalog.update(folder)
    return Answer(extended.package, rows, extended.diagnostics)


def _urdf(target: Path, extension: ModelExtension, given: bytes, out: Path | None) -> Answer:
    joints, rows = joint_physics(extension)
    path = target if out is None else out / target.name
    extend_urdf(target, joints, path)
    write_atomically(path.with_name(f"{path.stem}.{EXTENSION}"), given)
    return Answer(path, rows)


def _body(
    package: Path, record: AssetRecord, extension: ModelExtension, measurement: Path | None
) -> tuple[MeasuredBody | None, str]:
    """The declared body in the asset frame, or why it is not known."""
    if Path(extension.target.get("package", "")).name == record.asset_id:
        if (package / EXTENSION).exists():
            return None, _TWICE
        physics = record.physics
        return MeasuredBody(np.zeros(3), np.array(physics.inertia_kgm2.value) / physics.mass_kg.value), ""
    if measurement is None:
        return None, _NO_FRAME
    value = read(measurement).value
    if value is None or value.content_hash != extension.measurement:
        headline = f"the extension was not found on the measurement '{measurement.name}'"
        raise InvalidInput(finding("gap/invalid-extension", headline))
    from usdio.reread.body import reread_visual  # Loads USD, which refusals do not need.

    try:
        declared = build_body(value.spec, value.root)
    except ValueError as refused:
        raise InvalidInput(finding("gap/subject-unsupported-yet", str(refused))) from None
    points_A = reread_visual(main_file_of(package, record))[0]
    box_A, box_B = np.stack([points_A.min(axis=0), points_A.max(axis=0)]), bounds(declared.shapes)
    extent_A, extent_B = np.ptp(box_A, axis=0), np.ptp(box_B, axis=0)
    if not np.allclose(extent_A, extent_B, rtol=_SAME_SIZE):
        sizes = " against ".join(" x ".join(f"{v:.4g}" for v in e) for e in (extent_B, extent_A))
        return None, f"the measured body is not as large as the one in the package: {sizes} m"
    return MeasuredBody(box_A.mean(axis=0) - box_B.mean(axis=0), declared.inertia_B / declared.mass_kg), ""


def _row(row: Row) -> dict[str, Any]:
    values = {n: v.model_dump(mode="json") for n, v in row.values.items()}
    return {"effect": row.effect, "where": row.where, "parameters": values} | (
        {"files": list(row.written)} if row.written else {"why": row.why}
    )
