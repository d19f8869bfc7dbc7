"""Exports a package to a self-contained folder in MJCF, URDF or USDZ, with what the format could not hold."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Literal

import formats
from assetkit.export.description import (
    contact_losses,
    description_of,
    free_in_the_world,
    joint_losses,
)
from assetkit.export.surfaces import write_surfaces
from assetkit.package.package import reread
from assetkit.package.record import RECORD, read_record
from assetkit.package.write_twins import (
    UNSTATED_EFFORT,
    UNSTATED_SPEED,
    connected_points,
    for_mujoco,
    with_required_limits,
)
from assetkit.readers.usd import read_usd_still
from assetkit.sources.source_file import SourceFile
from formats.losses import WrittenDescription
from jobs.cache import changed_files, file_sha256
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.model import Model
from schemas.robot_description import RobotDescription
from usdio.reread.body import RereadPackage
from usdio.write.usdz import write_usdz

ExportFormat = Literal["mjcf", "urdf", "usdz"]
NOTE = "export.json"
_SUFFIX: dict[ExportFormat, str] = {"mjcf": ".xml", "urdf": ".urdf", "usdz": ".usdz"}


@dataclass(frozen=True)
class Exported:
    """The main file of an export, and a finding for everything that the format could not hold."""

    asset_id: str
    file: Path
    lost: tuple[Diagnostic, ...]


def export_package(package: Path, format_: ExportFormat, out: Path) -> Exported:
    """Write `out`/<format>/<asset id>/ with one main file, all that it refers to, and `export.json`.

    An export of the same asset that lies there is replaced. Raises InvalidInput `asset/package-invalid` for a folder
    that is no package, `asset/library-package-damaged` for one whose files are not those of its record, and
    `asset/output-occupied` where something else lies; OSError when writing fails.
    """
    record = _intact_record(package)
    target = out / format_ / record.asset_id
    if target.exists() and not (target / NOTE).is_file():
        headline = f"'{target.name}' in the output folder is no export of Mana"
        raise InvalidInput(finding("asset/output-occupied", headline, where=Location(file=target.name)))
    fresh = target.with_name(f".{target.name}.new")
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    file = fresh / f"{record.asset_id}{_SUFFIX[format_]}"
    main_file = package / "usd" / f"{record.asset_id}.usda"
    lost = _write_usdz(main_file, file) if format_ == "usdz" else _write_description(main_file, file, record, format_)
    lost = (*lost, *_record_losses(record, format_))
    (fresh / NOTE).write_text(_note(package, record, format_, lost))
    shutil.rmtree(target, ignore_errors=True)
    fresh.rename(target)
    return Exported(record.asset_id, target / file.name, lost)


def _intact_record(package: Path) -> AssetRecord:
    record = read_record(package.resolve())
    if record is None:
        where = Location(file=package.name)
        raise InvalidInput(finding("asset/package-invalid", f"'{package.name}' is no package of Mana", where=where))
    changed = changed_files(package, record.hashes)
    if changed:
        headline = f"{len(changed)} files are absent or not those of the record: {', '.join(changed[:5])}"
        raise InvalidInput(finding("asset/library-package-damaged", headline, where=Location(file=package.name)))
    return record


def _write_usdz(main_file: Path, file: Path) -> tuple[Diagnostic, ...]:
    without_mdl = write_usdz(main_file, file)
    if not without_mdl:
        return ()
    headline = f"USDZ holds no MDL modules: {', '.join(without_mdl)} keep the other surfaces"
    return (finding("asset/export-loss", headline, value=len(without_mdl), unit="materials"),)


def _write_description(
    main_file: Path, file: Path, record: AssetRecord, format_: ExportFormat
) -> tuple[Diagnostic, ...]:
    mjcf = format_ == "mjcf"
    content = reread(main_file)
    model = _visible(main_file)
    links = [PurePosixPath(mesh.source_path).parts[-3] for mesh in model.meshes]  # <root>/[<link>/]Visuals/<mesh>
    surfaces = write_surfaces(model, links, _origins(content), file.parent)
    description = description_of(record.asset_id, content, surfaces.shapes, file.parent)
    written = _as_mjcf(description, content) if mjcf else formats.write_urdf(with_required_limits(description))
    file.write_bytes(written.data)
    losses = (
        *surfaces.lost,
        *map(_as_loss, written.lost),
        *contact_losses(content, mjcf=mjcf),
        *joint_losses(content, mjcf=mjcf),
    )
    return (*losses, *(() if mjcf else _added_limits(description)))


def _as_loss(lost: Diagnostic) -> Diagnostic:
    """A loss of the writer of the format under the one code of exports."""
    return finding("asset/export-loss", lost.headline, severity=lost.severity)


def _as_mjcf(description: RobotDescription, content: RereadPackage) -> WrittenDescription:
    mechanism = content.mechanism
    pairs = () if mechanism is None else connected_points(mechanism)
    placed = for_mujoco(description)
    if mechanism is None or not mechanism.fixed_base:
        placed = free_in_the_world(placed)
    return formats.write_mjcf(placed, pairs, content.filtered_pairs)


def _visible(main_file: Path) -> Model:
    """The visible meshes of a package with their materials, at rest in the asset frame."""
    outcome = read_usd_still(SourceFile(main_file, main_file.parent))
    assert outcome.value is not None  # what cannot be read raises
    return outcome.value.with_mesh_ids()


def _origins(content: RereadPackage) -> dict[str, FloatArray]:
    """Where the frame of each link lies (3,) in the asset frame at rest."""
    mechanism = content.mechanism
    if mechanism is None:
        return {content.body.name: content.body.mass.centre_of_mass_m * 0.0}
    return {link.name: link.origin for link in mechanism.links}


def _added_limits(description: RobotDescription) -> Iterator[Diagnostic]:
    """What URDF requires and the package does not state."""
    names = [j.name for j in description.joints if j.limits is not None and not (j.effort and j.velocity)]
    if names:
        headline = (
            f"URDF asks for effort and velocity of limited joints: {UNSTATED_EFFORT:g} and {UNSTATED_SPEED:g} are "
            f"written where they are not stated ({', '.join(names)})"
        )
        yield finding("asset/export-loss", headline, severity=Severity.INFO, value=len(names), unit="joints")


def _record_losses(record: AssetRecord, format_: ExportFormat) -> Iterator[Diagnostic]:
    """What only the record and the package's own USD hold."""
    counts = {"anchors": len(record.anchors), "uses of joints": len(record.joint_uses)}
    if format_ != "usdz":  # the USD has lines of grasps, face subsets of parts and labels
        counts = {"grasps": len(record.affordances), "parts": len(record.parts), **counts}
    names = [f"{count} {name}" for name, count in counts.items() if count]
    if names:
        headline = f"the record of the package alone holds {', '.join(names)}"
        yield finding("asset/export-loss", headline, severity=Severity.INFO, value=sum(counts.values()))


def _note(package: Path, record: AssetRecord, format_: ExportFormat, lost: tuple[Diagnostic, ...]) -> str:
    note = {
        "asset_id": record.asset_id,
        "format": format_,
        "tool": f"mana-sim {version('mana-sim')}",
        "record_sha256": file_sha256(package / RECORD),
        "license": record.source.license.value,
        "author": record.source.author.value,
        "lost": [each.model_dump(mode="json") for each in lost],
    }
    return json.dumps(note, indent=1) + "\n"
