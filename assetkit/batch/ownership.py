"""Which source owns which package of an output folder, across runs: a source never replaces a namesake's package."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from assetkit.package.record import read_record
from assetkit.sources.discover import SourceAsset, slug
from jobs.cache import content_key, write_atomically

OWNERS = ".cache/owners"  # below the output folder: for each package a file of its name, with the path of its source
PACKAGE_LISTS = ".cache/made"  # for each source a file with the names of its packages


def resolve_asset_id(candidate: SourceAsset, out: Path) -> SourceAsset:
    """The candidate, with a suffixed id when an earlier run gave its id to another source that still exists."""
    owner = _owner(candidate.asset_id, out)
    if owner is None or owner == candidate.file.path.absolute() or not owner.is_file():
        return candidate
    suffix = content_key(candidate.given)[:6]
    return replace(candidate, asset_id=f"{slug(candidate.file.path.stem)}-{suffix}")


def record_ownership(candidate: SourceAsset, packages: Sequence[str], out: Path, *, complete: bool = True) -> None:
    """Record which packages this source made, and remove those it made before and no longer makes.

    Not `complete`: something else than the source ended the work, so packages made before stay with their owner.
    """
    source = str(candidate.file.path.absolute())
    for package in packages:
        write_atomically(_owner_note(package, out), os.fsencode(source))
    package_list = out / PACKAGE_LISTS / content_key(source)[:24]
    before = package_list.read_text().splitlines() if package_list.is_file() else []
    if not complete:
        packages = tuple(dict.fromkeys([*before, *packages]))
    for package in set(before) - set(packages):
        if _owner(package, out) == Path(source) and read_record(out / package) is not None:
            shutil.rmtree(out / package)
        _owner_note(package, out).unlink(missing_ok=True)
    write_atomically(package_list, "\n".join(packages).encode())


def _owner(asset_id: str, out: Path) -> Path | None:
    note = _owner_note(asset_id, out)
    return Path(os.fsdecode(note.read_bytes())) if note.is_file() else None


def _owner_note(package: str, out: Path) -> Path:
    return out / OWNERS / package
