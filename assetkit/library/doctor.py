"""Examines the folder of a library after crashes: do packages, catalog and notes agree, and does nothing lie about?

Only what is safe is repaired: nothing is ever deleted that somebody could still want. A damaged package stays where it
is; `mana assets ingest` of its source makes it anew.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from assetkit.batch.ownership import OWNERS
from assetkit.library import catalog
from assetkit.library.leftovers import remove, replaced_packages, written_aside
from assetkit.package.record import RECORD, read_record
from jobs.cache import changed_files, file_sha256
from jobs.lock import exclusive
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding

_SHOWN = 5  # names of files in one finding


@dataclass(frozen=True)
class Examination:
    """What was found in a library, and which of it was repaired, in the same order; `packages` are those examined."""

    packages: int
    findings: tuple[Diagnostic, ...]
    repaired: tuple[bool, ...]

    @property
    def healthy(self) -> bool:
        """Whether nothing is left to do."""
        return all(self.repaired)


@dataclass(frozen=True)
class _Symptom:
    """A finding, and the repair that is safe, if there is one."""

    finding: Diagnostic
    repair: Callable[[], object] | None = None


def examine(out: Path, *, repair: bool = True) -> Examination:
    """Check every invariant of the library in `out`, and repair what is safe unless `repair` is False.

    Raises FolderInUse while a batch writes into it: what it has not finished yet is no damage.
    """
    with exclusive(out):
        packages, symptoms = 0, [*_interrupted_replacements(out)]
        repaired = [_treat(symptom, repair) for symptom in symptoms]
        for check in (_leftovers, _packages, _owners, _catalog):
            for symptom in check(out):
                symptoms.append(symptom)
                repaired.append(_treat(symptom, repair))
        packages = sum(1 for _ in out.glob(f"[!.]*/{RECORD}"))
    return Examination(packages, tuple(symptom.finding for symptom in symptoms), tuple(repaired))


def _treat(symptom: _Symptom, repair: bool) -> bool:
    if not repair or symptom.repair is None:
        return False
    symptom.repair()
    return True


def _interrupted_replacements(out: Path) -> Iterator[_Symptom]:
    """Packages that a killed process was about to replace: the old one stands aside as `.NAME.old`."""
    for old, place in replaced_packages(out):
        if place.exists():
            yield _Symptom(_left_over(old, "the package that replaced it is in place"), lambda old=old: remove(old))
        else:
            found = finding(
                "asset/library-interrupted",
                f"the package '{place.name}' was being replaced when its process ended",
                where=Location(file=old.name),
            )
            yield _Symptom(found, lambda old=old, place=place: old.rename(place))


def _leftovers(out: Path) -> Iterator[_Symptom]:
    """Files that were written aside by a process that ended before it moved them into place."""
    for path in written_aside(out):
        yield _Symptom(_left_over(path, "no process works on it"), lambda path=path: remove(path))


def _packages(out: Path) -> Iterator[_Symptom]:
    """Packages whose files are not those of their record, and folders that were packages and have no record."""
    owned = {note.name for note in (out / OWNERS).glob("*")}
    for folder in sorted(p for p in out.iterdir() if p.is_dir() and not p.name.startswith(".")):
        record = read_record(folder)
        if record is None:
            if folder.name in owned or (folder / RECORD).exists():
                yield _damaged(folder.name, f"no record of '{folder.name}' can be read", (RECORD,))
            continue
        changed = changed_files(folder, record.hashes)
        if changed:
            yield _damaged(folder.name, f"{len(changed)} files are absent or not those of the record", tuple(changed))


def _owners(out: Path) -> Iterator[_Symptom]:
    """Notes of ownership of packages that are not there."""
    for note in sorted((out / OWNERS).glob("*")):
        if not (out / note.name).exists():
            found = finding(
                "asset/library-owner-dangling",
                f"a source is noted as the owner of '{note.name}', which is not there",
                where=Location(file=note.relative_to(out).as_posix()),
            )
            yield _Symptom(found, note.unlink)


def _catalog(out: Path) -> Iterator[_Symptom]:
    """A catalog that was not made from exactly the records that are there."""
    there = {record.asset_id: file_sha256(package / RECORD) for package, record in catalog.records(out)}
    try:
        listed = catalog.fingerprints(out)
    except (FileNotFoundError, InvalidInput, sqlite3.Error):
        listed = None if there else {}
    if listed != there:
        other = sorted(dict(listed.items() ^ there.items()) if listed is not None else there)
        headline = "the catalog cannot be read" if listed is None else f"{len(other)} packages differ in the catalog"
        found = finding(
            "asset/library-catalog-stale",
            f"{headline}: {', '.join(other[:_SHOWN])}",
            where=Location(file=catalog.CATALOG),
        )
        yield _Symptom(found, lambda: catalog.rebuild(out))


def _damaged(name: str, headline: str, files: tuple[str, ...]) -> _Symptom:
    shown = ", ".join(files[:_SHOWN])
    return _Symptom(finding("asset/library-package-damaged", f"{headline}: {shown}", where=Location(file=name)))


def _left_over(path: Path, why: str) -> Diagnostic:
    return finding("asset/library-leftover", f"'{path.name}' is left over: {why}", where=Location(file=path.name))
