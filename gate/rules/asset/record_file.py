"""Rule: the files of a package are the ones its record.json was written for."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from gate.rules.rule import Rule
from gate.subject import Subject
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Location, finding

CODE = DiagnosticCode(
    "asset/gate-record-file",
    "A file of the package is not the one its record.json was written for",
    "It was changed, replaced or removed after release, so no figure of the record holds for it.",
    "restore the file, or ingest the source again; a change that is meant needs a new record",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per file of the record's `hashes` that is absent or has other bytes; value and bound are SHA-256.

    Files that the record does not list are left alone: nothing in the package could name them without a changed byte.
    """
    hashes = subject.record_value("hashes")
    for name, expected in sorted(hashes.items()) if isinstance(hashes, dict) else ():
        found = _sha256(subject.package_folder, name)
        if found is None:
            yield finding(CODE, "a file of the record is absent", where=Location(file=name), bound=str(expected))
        elif found != expected:
            headline = "the file is not the one that was released"
            yield finding(CODE, headline, where=Location(file=name), value=found, bound=str(expected), unit="sha256")


def _sha256(folder: Path, name: str) -> str | None:
    """Of a file inside `folder`; None for one that is absent, unreadable or outside."""
    try:
        path = (folder / name).resolve()
        if not path.is_relative_to(folder) or not path.is_file():
            return None
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return None


RULE = Rule(CODE, "SHA-256 of every file in `hashes` of record.json", "AssetRecord (`mana schema asset`)", check)
