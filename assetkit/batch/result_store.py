"""The store of finished items on disk, with the hashes they depend on: a later run skips sources without changes."""

from __future__ import annotations

import os
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from assetkit.options import Options
from assetkit.package.record import RECORD, read_record
from assetkit.sources.discover import SourceAsset
from jobs.cache import changed_files, content_key, file_sha256, write_atomically
from jobs.versions import library_versions, versions_key
from schemas.report import ReportItem

ITEMS = ".cache/items"  # below the output folder


class StoredResult(BaseModel):
    """A finished item with what it depended on.

    `references` maps each file read (relative to the asset's root) to its hash; `missing` lists the places
    where absent ones would lie; `records` maps each package to the hash of its record; `versions` is the
    `jobs.versions.versions_key` under which it was made.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    item: ReportItem
    main_sha256: str
    references: dict[str, str] = {}
    missing: tuple[str, ...] = ()
    records: dict[str, str] = {}
    versions: str = ""


def result_file(candidate: SourceAsset, out: Path, options: Options) -> Path:
    """The path of the stored result of a source under these options and libraries."""
    root = os.path.relpath(candidate.file.root, candidate.file.path.parent)
    date = os.environ.get("SOURCE_DATE_EPOCH", "")
    identity = (candidate.given, candidate.asset_id, root, options.model_dump(), library_versions(), date)
    return out / ITEMS / f"{content_key(identity)}.json"


def read_stored(note: Path) -> StoredResult | None:
    """The stored result in file `note`, None when there is none or it cannot be read."""
    try:
        return StoredResult.model_validate_json(note.read_bytes())
    except (OSError, ValueError):
        return None


def write_stored(note: Path, stored: StoredResult) -> None:
    """Write a result to file `note` atomically, so that it is there after a power cut, with the versions at work."""
    marked = stored.model_copy(update={"versions": versions_key()})
    write_atomically(note, marked.model_dump_json().encode(), durable=True)


def stored_from(item: ReportItem, candidate: SourceAsset, out: Path) -> StoredResult:
    """The result to store for an item that has just been made. Raises OSError when its files have vanished since."""
    root = candidate.file.root.resolve()
    visited = {p for p in candidate.file.visited if p != candidate.file.path.resolve()}
    return StoredResult(
        item=item,
        main_sha256=file_sha256(candidate.file.path),
        references={p.relative_to(root).as_posix(): file_sha256(p) for p in sorted(visited)},
        missing=tuple(sorted(candidate.file.missing)),
        records={name: file_sha256(out / name / RECORD) for name in item.packages},
    )


def is_current(stored: StoredResult, candidate: SourceAsset, out: Path) -> bool:
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
    record = read_record(package)
    return record is not None and not changed_files(package, record.hashes)
