"""Check every variant below a folder: clearances (m), settling, and equal bits of all recorded streams."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from replay.recording.episode import Episode
from replay.recording.formats.digests import stream_digests
from replay.recording.formats.read import read_episodes
from replay.recording.recorded_numbers import invalid_recording
from replay.verification.inserted_bodies import InsertedBody, inserted_body
from replay.verification.link_check import check_links
from replay.verification.settling import Settle, settling_motion
from replay.verification.verify import near_pairs
from schemas.replay.documents import VARIANT_FILE, Inserted, Moved, Variant, VariantCheck

AT_ONCE = 32  # Variants that share one dense replay of their recording.


def check_output(
    out: Path,
    packages: Path | None,
    settle: Settle | None,
    clearance_m: float | None = None,
    meshes: Path | None = None,
) -> list[VariantCheck]:
    """One row for each `variant.json` below a folder, in the order of their paths.

    `packages` holds the packages that the variants name, `clearance_m` overrides what each variant states; without
    `settle` settling is not checked. Raises InvalidInput.
    """
    folders = sorted(p.parent for p in out.rglob(VARIANT_FILE))
    if not folders:
        raise invalid_recording("replay/missing-file", f"no {VARIANT_FILE} below '{out.name}'", out.name)
    checks: dict[Path, VariantCheck] = {}
    groups: dict[tuple[object, ...], list[tuple[Path, Variant]]] = {}
    for folder in folders:
        variant = read_variant(folder)
        digests = tuple(sorted(stream_digests(recording(folder, variant), variant.part).items()))
        key = (variant.source, variant.part, variant.scene, variant.meshes, digests, variant.clearance_m)
        groups.setdefault(key, []).append((folder, variant))
    for group in groups.values():
        episode = read_variant_episode(*group[0], meshes)
        for first in range(0, len(group), AT_ONCE):
            batch = group[first : first + AT_ONCE]
            checks |= _check_group(out, episode, batch, packages, settle, clearance_m)
    return [checks[folder] for folder in folders]


def read_variant(folder: Path) -> Variant:
    """The `variant.json` of a folder. Raises InvalidInput."""
    if not (folder / VARIANT_FILE).is_file():
        raise invalid_recording("replay/missing-file", f"no {VARIANT_FILE} in '{folder.name}'", folder.name)
    try:
        return Variant.model_validate_json((folder / VARIANT_FILE).read_bytes())
    except ValidationError as error:
        raise invalid_recording(
            "replay/invalid-value", f"{folder.name}/{VARIANT_FILE}: {error}", VARIANT_FILE
        ) from None


def recording(folder: Path, variant: Variant) -> Path:
    """The copy of the recording below the variant's folder. Raises InvalidInput."""
    path = (folder / variant.recording).resolve()
    if not variant.recording or not path.is_relative_to(folder.resolve()):
        raise invalid_recording(
            "replay/path-escape", f"recording '{variant.recording}' is not beside the variant", VARIANT_FILE
        )
    if not path.exists():
        raise invalid_recording(
            "replay/missing-file", f"recording '{variant.recording}' of the variant is absent", VARIANT_FILE
        )
    return path


def read_variant_episode(folder: Path, variant: Variant, meshes: Path | None = None) -> Episode:
    """The recording as the variant's folder holds it, read with the scene and the meshes that it was read with before.

    Where these are gone, `meshes` are the ones to take. Raises InvalidInput.
    """
    named = [Path(p) for p in (variant.meshes, str(Path(variant.source).parent)) if p and Path(p).is_dir()]
    scene = Path(variant.scene) if variant.scene and Path(variant.scene).is_file() else None
    episodes = read_episodes(recording(folder, variant), meshes or next(iter(named), None), scene)
    matching = next((e for e in episodes if e.part == variant.part), None)
    if matching is None:
        raise invalid_recording(
            "replay/missing-file", f"the copy of the recording has no '{variant.part}'", VARIANT_FILE
        )
    return matching


def _check_group(
    out: Path,
    episode: Episode,
    group: Sequence[tuple[Path, Variant]],
    packages: Path | None,
    settle: Settle | None,
    clearance_m: float | None,
) -> dict[Path, VariantCheck]:
    bodies = [[_body(one, packages) for one in variant.inserted] for _, variant in group]
    required_m = group[0][1].clearance_m if clearance_m is None else clearance_m
    pairs = near_pairs(episode, bodies, required_m)
    links = check_links(episode)
    rows = {}
    for (folder, variant), inserted, near in zip(group, bodies, pairs, strict=True):
        under = tuple(pair for pair in near if pair.distance_m < required_m)
        rows[folder] = VariantCheck(
            variant=folder.relative_to(out).as_posix(),
            objects_requested=variant.objects_requested,
            objects_inserted=len(variant.inserted),
            contacts=sum(pair.distance_m <= 0.0 for pair in near),
            clearance_m=required_m,
            clearance_violations=len(under),
            nearest=near[0] if near else None,
            near=under,
            moved=_settling_motion(episode, inserted, settle),
            states_identical=_identical(folder, variant),
            feasible_area_m2=sum(variant.feasible_area_m2.values()) if variant.feasible_area_m2 else None,
            newly_hidden_fraction=max(variant.camera_hidden.values(), default=None),
            notes=tuple(note.headline for note in episode.notes),
            link_error_m=max((link.distance_m for link in links), default=None),
            link_error_deg=max((link.angle_deg for link in links), default=None),
        )
    return rows


def _body(inserted: Inserted, packages: Path | None) -> InsertedBody:
    try:
        return inserted_body(inserted, packages)
    except (FileNotFoundError, ValueError) as error:
        message = f"package '{inserted.package}' of '{inserted.name}' is not in the folder of packages: {error}"
        raise invalid_recording("replay/missing-file", message, VARIANT_FILE) from None


def _settling_motion(episode: Episode, inserted: list[InsertedBody], settle: Settle | None) -> tuple[Moved, ...]:
    return settling_motion(episode, inserted, settle) if settle and inserted else ()


def _identical(folder: Path, variant: Variant) -> bool:
    """Whether the copy's streams have the digests that the variant states, and those of the source if it is there."""
    copied = stream_digests(recording(folder, variant), variant.part)
    source = Path(variant.source)
    sources = [variant.source_sha256] + ([stream_digests(source, variant.part)] if source.exists() else [])
    return bool(copied) and all(copied == digests for digests in sources)


def summary(checks: Iterable[VariantCheck]) -> dict[str, Any]:
    """The figures over all variants under the names that outside tools rely on (docs: replay)."""
    rows = list(checks)
    inserted = [row.objects_inserted for row in rows]
    least = [row.nearest.distance_m for row in rows if row.nearest]
    areas = [row.feasible_area_m2 for row in rows if row.feasible_area_m2 is not None]
    hidden = [row.newly_hidden_fraction for row in rows if row.newly_hidden_fraction is not None]
    moved = [thing for row in rows for thing in row.moved]
    return {
        "variants": len(rows),
        "objects_requested": max(row.objects_requested for row in rows),
        "objects_inserted": {"min": min(inserted), "median": statistics.median(inserted)},
        "contacts": sum(row.contacts for row in rows),
        "clearance_m": min(row.clearance_m for row in rows),
        "clearance_violations": sum(row.clearance_violations for row in rows),
        "min_clearance_m": min(least, default=None),
        "feasible_area_m2": statistics.median(areas) if areas else None,
        "newly_hidden_fraction": max(hidden, default=None),
        "states_identical": all(row.states_identical for row in rows),
        "settled": len(moved),
        "settle_failures": sum(not thing.stayed for thing in moved),
        "most_moved_m": max((thing.moved_m for thing in moved), default=None),
        "most_turned_deg": max((thing.turned_deg for thing in moved), default=None),
        "link_error_m": max((row.link_error_m for row in rows if row.link_error_m is not None), default=None),
        "link_error_deg": max((row.link_error_deg for row in rows if row.link_error_deg is not None), default=None),
        "notes": sorted({note for row in rows for note in row.notes}),
        "sound": sum(row.sound for row in rows),
    }
