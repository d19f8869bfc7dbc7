"""Finds and removes what no package, record or later run of a library can use any more.

Packages, records, `decisions.jsonl` and answers of annotators, which cost money, are never garbage. A stored result is
garbage when this installation cannot read it again (its key holds the versions of libraries and code), or when it
rests on a package that is gone or has another record. Every file is removed on its own and in an order in which the
rest stays valid, so a process that is killed half-way leaves a library that the next run cleans further.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from assetkit.batch.ownership import OWNERS, PACKAGE_LISTS
from assetkit.batch.result_store import ITEMS, read_stored
from assetkit.library import catalog
from assetkit.library.leftovers import remove, replaced_packages, written_aside
from assetkit.package.record import RECORD
from assetkit.pipeline import NOTE_SUFFIX, STAGE_RESULTS, StoredNotes
from jobs.cache import file_sha256
from jobs.lock import exclusive
from jobs.versions import versions_key
from schemas.files import array_files

CACHE = ".cache"
_VALUE_SUFFIX = ".npz"
_WRITTEN_ASIDE = re.compile(r"\..+\.\d+")  # `.NAME.PID`, see `jobs.cache.write_atomically`
_HISTORY_KEY = 16  # characters of a stage's key in the history of a record


class Garbage(NamedTuple):
    """One file or folder to remove, and of which kind it is."""

    path: Path
    kind: str


@dataclass
class FreedSpace:
    """How many files of one kind were (or would be) removed, and their size."""

    kind: str
    files: int = 0
    size_bytes: int = 0

    def add(self, path: Path) -> None:
        """Count a file, or all files of a folder."""
        folder = path.is_dir() and not path.is_symlink()
        for file in [p for p in path.rglob("*") if p.is_symlink() or p.is_file()] if folder else [path]:
            self.files += 1
            self.size_bytes += file.lstat().st_size


def collect_garbage(
    out: Path,
    *,
    unnamed: bool = False,
    dry_run: bool = False,
    removed: Callable[[Garbage], None] | None = None,
) -> tuple[FreedSpace, ...]:
    """Remove the garbage of the library `out`, or only measure it; the space by kind.

    `unnamed` also takes stage results that no record names: those of rejected items and of runs that were cut short.
    `removed` is called after each removal. Raises FolderInUse while a batch writes into `out`: all that it has not
    finished is its own.
    """
    freed: dict[str, FreedSpace] = {}
    with exclusive(out):
        for item in find_garbage(out, unnamed=unnamed):
            freed.setdefault(item.kind, FreedSpace(item.kind)).add(item.path)
            if dry_run:
                continue
            remove(item.path)
            if removed is not None:
                removed(item)
    return tuple(freed[kind] for kind in sorted(freed))


def find_garbage(out: Path, *, unnamed: bool = False) -> Iterator[Garbage]:
    """Every file and folder that is garbage; the caller holds the lock of `out`."""
    for old, place in replaced_packages(out):
        if place.exists():  # else it is the only copy, which `mana assets doctor` puts back
            yield Garbage(old, "replaced packages")
    for path in written_aside(out):
        yield Garbage(path, "partial files and folders")
    yield from _partial_results(out)
    yield from _stored_items(out)
    yield from _stage_results(out, _named_keys(out) if unnamed else None)
    yield from _notes(out)


def _partial_results(out: Path) -> Iterator[Garbage]:
    for path in sorted((out / CACHE).rglob(".*")):
        if _WRITTEN_ASIDE.fullmatch(path.name):
            yield Garbage(path, "partial files and folders")


def _stored_items(out: Path) -> Iterator[Garbage]:
    """Stored items that no run takes any more: of other versions, damaged, or of packages that are not there so."""
    for note in sorted((out / ITEMS).glob("*.json")):
        stored = read_stored(note)
        if stored is None or stored.versions != versions_key():
            yield Garbage(note, "stored items of other versions")
        elif any(not _has_record(out / name, sha) for name, sha in stored.records.items()):
            yield Garbage(note, "stored items of packages that are gone or newer")


def _has_record(package: Path, sha256: str) -> bool:
    return (package / RECORD).is_file() and file_sha256(package / RECORD) == sha256


def _stage_results(out: Path, named: set[str] | None) -> Iterator[Garbage]:
    """Values of stages with their notes, the value first: a note alone is never read, and is garbage itself.

    `named` are the beginnings of keys to keep; None keeps all that this installation can read.
    """
    for folder in sorted((out / CACHE / STAGE_RESULTS).glob("*/*")):
        names = sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))
        for key in dict.fromkeys(name.partition(".")[0] for name in names):
            files = [folder / f"{key}{suffix}" for suffix in (_VALUE_SUFFIX, NOTE_SUFFIX)]
            kind = _kind_of_garbage(files[0], files[1], key, named)
            if kind:
                yield from (Garbage(file, kind) for file in files if file.exists())


def _kind_of_garbage(value: Path, note: Path, key: str, named: set[str] | None) -> str:
    """Why a stage result is garbage; empty where it is none."""
    if not (value.exists() and note.exists()):
        return "partial files and folders"
    try:
        versions = array_files.load(StoredNotes, note).versions
    except (OSError, ValueError, KeyError):
        versions = ""
    if versions != versions_key():
        return "stage results of other versions"
    if named is not None and key[:_HISTORY_KEY] not in named:
        return "stage results that no record names"
    return ""


def _named_keys(out: Path) -> set[str]:
    """Beginnings of the keys of all stages in the histories of all records."""
    return {entry.key for _, record in catalog.records(out) for entry in record.history}


def _notes(out: Path) -> Iterator[Garbage]:
    """Notes on sources all of whose packages are gone."""
    for note in sorted((out / OWNERS).glob("*")):
        if not (out / note.name).exists():
            yield Garbage(note, "notes on packages that are gone")
    for listed in sorted((out / PACKAGE_LISTS).glob("[!.]*")):
        if not any((out / name).exists() for name in listed.read_text().splitlines() if name):
            yield Garbage(listed, "notes on packages that are gone")
