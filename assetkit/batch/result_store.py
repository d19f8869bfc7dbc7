"""What became of each source, on disk: lets a later run skip what has not changed."""

from __future__ import annotations

import os
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from assetkit.options import Options
from assetkit.package.record import RECORD, read_record
from assetkit.sources.discover import Candidate
from assetkit.versions import library_versions
from jobs.cache import changed_files, content_key, file_sha256, write_atomically
from schemas.report import ReportItem


class Stored(BaseModel):
    """A finished item with what it depended on.

    `references` maps each file read (relative to the asset's root) to its hash; `missing` lists the places
    where absent ones would lie; `records` maps each package to the hash of its record.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    item: ReportItem
    main_sha256: str
    references: dict[str, str] = {}
    missing: tuple[str, ...] = ()
    records: dict[str, str] = {}


def file_of(candidate: Candidate, out: Path, options: Options) -> Path:
    """Where the result of a source under these options and libraries is remembered."""
    root = os.path.relpath(candidate.file.root, candidate.file.path.parent)
    date = os.environ.get("SOURCE_DATE_EPOCH", "")
    identity = (candidate.given, candidate.asset_id, root, options.model_dump(), library_versions(), date)
    return out / ".cache" / "items" / f"{content_key(identity)}.json"


def recall(note: Path) -> Stored | None:
    """What is remembered, or None; an unreadable note counts as none."""
    try:
        return Stored.model_validate_json(note.read_bytes())
    except (OSError, ValueError):
        return None


def remember(note: Path, stored: Stored) -> None:
    """Write a note atomically."""
    write_atomically(note, stored.model_dump_json().encode())


def stored_from(item: ReportItem, candidate: Candidate, out: Path) -> Stored:
    """The note for an item that has just been made. Raises OSError when its files have vanished since."""
    root = candidate.file.root.resolve()
    visited = {p for p in candidate.file.visited if p != candidate.file.path.resolve()}
    return Stored(
        item=item,
        main_sha256=file_sha256(candidate.file.path),
        references={p.relative_to(root).as_posix(): file_sha256(p) for p in sorted(visited)},
        missing=tuple(sorted(candidate.file.missing)),
        records={name: file_sha256(out / name / RECORD) for name in item.packages},
    )


def is_current(stored: Stored, candidate: Candidate, out: Path) -> bool:
    """Whether the source files are as they were and every package is still there, byte for byte."""
    root = candidate.file.root
    if not candidate.file.path.is_file() or file_sha256(candidate.file.path) != stored.main_sha256:
        return False
    for name, sha in stored.references.items():
        path = root / name
        if not path.is_file() or file_sha256(path) != sha:
            return False
    if any((root / name).is_file() for name in stored.missing):
        return False
    return all(_is_intact(out / name, sha) for name, sha in stored.records.items())


def _is_intact(package: Path, record_sha256: str) -> bool:
    if changed_files(package, {RECORD: record_sha256}):
        return False
    found = read_record(package)
    return found is not None and not changed_files(package, found.hashes)
