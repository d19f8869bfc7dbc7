"""Pictures of a source file or a package in modes: what is on record of the object goes onto the sheet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from assetkit.library.validate import main_usd_files
from assetkit.package.preview_images import render_mode, shown_parts
from assetkit.package.record import RECORD, read_record
from render.modes.request import DrawnMass, Mode, ModeRequest, views_around
from render.modes.sheet import plain_number
from schemas.asset import AssetRecord
from schemas.model import Model
from schemas.parts import Part
from schemas.physics import CollisionShape, MassProperties
from usdio.reread.body import RereadPackage, reread_package

_OF_PHYSICS = frozenset({"collision", "physics"})  # modes that show what a simulator reads


def draw_modes(path: Path, model: Model, out: Path, modes: Sequence[str], views: int, size_px: int) -> list[Path]:
    """Draws a canonical model in each mode, as many views of it, and the sheets; returns the PNGs written.

    `path` is the source file, or the package, whose colliders, masses, parts and record are shown.
    """
    needed = path.is_dir() and not _OF_PHYSICS.isdisjoint(modes)
    content = reread_package(main_usd_files(path)[0]) if needed else None
    record = read_record(path) if path.is_dir() and (path / RECORD).is_file() else None
    parts = _fitting(model, () if record is None else [part.value for part in record.parts])
    legend, part_of = shown_parts(model, parts) if parts else ((), None)
    shapes: tuple[CollisionShape, ...] = () if content is None else content.body.shapes
    masses = () if content is None else _masses(content)
    title = path.stem if record is None else record.asset_id
    facts = _facts(model, record)
    out.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for mode in modes:
        request = ModeRequest(
            cast(Mode, mode), model, str(out), f"{title}: {mode}", facts, shapes, masses, legend, part_of, size_px,
            views_around(views),
        )  # fmt: skip
        written += render_mode(request)
    return written


def _fitting(model: Model, parts: Sequence[Part]) -> list[Part]:
    """The parts whose triangles the model has: a package that was edited by hand may hold others."""
    counts = {mesh_id: len(mesh.triangles) for mesh_id, mesh in model.meshes_by_id.items()}
    return [
        part for part in parts if all(len(f.indices) and int(f.indices[-1]) < counts.get(f.mesh, 0) for f in part.faces)
    ]


def _masses(content: RereadPackage) -> tuple[DrawnMass, ...]:
    """Of the body, or of each link at rest; frames of links differ from that of the asset by their origin alone."""
    if content.mechanism is None:
        return (_mass(content.body.name, content.body.mass, np.zeros(3)),)
    origins = {link.name: link.origin for link in content.mechanism.links}
    return tuple(_mass(body.name, body.mass, np.asarray(origins[body.name])) for body in content.links)


def _mass(name: str, mass: MassProperties, origin: np.ndarray) -> DrawnMass:
    moments, axes = np.linalg.eigh(mass.inertia_kgm2)
    return DrawnMass(name, mass.mass_kg, mass.centre_of_mass_m + origin, moments, axes)


def _facts(model: Model, record: AssetRecord | None) -> tuple[str, ...]:
    """Lines below the title: size and triangles; of a package also outcome, mass and contact with their evidence."""
    points = np.concatenate([mesh.points for mesh in model.meshes])
    size_cm = " x ".join(plain_number(100.0 * float(edge)) for edge in np.ptp(points, axis=0))
    materials = f"{len(model.materials)} material{'' if len(model.materials) == 1 else 's'}"
    first = f"{size_cm} cm, {model.triangle_count:,} triangles, {materials}"
    if record is None:
        return (first,)
    roles = ", ".join(role.value for role in record.semantics.roles)
    mass, material = record.physics.mass_kg, record.physics.material
    lines = [f"{first}; {record.outcome}; {record.semantics.category.value}{f' ({roles})' if roles else ''}"]
    if mass.value is not None:
        lines.append(f"mass {plain_number(mass.value)} kg ({mass.source}, {100 * mass.confidence:.0f} % sure)")
    for contact in record.physics.contacts[:1]:
        value = contact.value
        friction = f"friction {value.static_friction:.2g} static, {value.dynamic_friction:.2g} dynamic"
        lines.append(f"{material.value}: {friction} ({contact.source}, {100 * contact.confidence:.0f} % sure)")
    return tuple(lines)
