"""Validates one USD asset with the external validators and the gate; also the entry point of a cell that does so."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

from gate.external_validators import SIMREADY, ValidatorVerdict, external_verdicts
from gate.static_gate import claims_release, gate
from jobs.cache import write_atomically
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from usdio.read.usdz import check_package

_RANK = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.INFO: 2}


def validate_file(file: Path, *, external: bool = True) -> tuple[Diagnostic, ...]:
    """All findings of the external validators (unless `external` is False) and of the gate, gravest first.

    One finding when the file cannot be opened, or is an archive that no reader should open. Findings on SimReady
    requirements are `info` for a file that does not claim to be a SimReady package.
    """
    try:
        if file.suffix.lower() == ".usdz":
            check_package(file, where=Location(file=file.name))
        verdicts = external_verdicts(file) if external else ()
    except InvalidInput as unreadable:
        return (unreadable.diagnostic,)
    findings = [d for verdict in verdicts for d in _findings(verdict, file)]
    return tuple(sorted([*findings, *gate(file)], key=lambda d: _RANK[d.severity]))


def _findings(verdict: ValidatorVerdict, file: Path) -> Iterator[Diagnostic]:
    claimed = verdict.validator != SIMREADY or claims_release(file)
    code = "asset/simready-rule" if verdict.validator == SIMREADY else "asset/usd-rule"
    for severity, remarks in (
        (Severity.ERROR if claimed else Severity.INFO, verdict.findings),
        (Severity.WARNING if claimed else Severity.INFO, verdict.warnings),
    ):
        for remark in remarks:
            where = Location(prim=remark.prim) if remark.prim else Location(file=file.name)
            yield finding(code, str(remark), where=where, severity=severity)


def main(file: str, note: str, extent: str) -> None:
    """Validate `file` and write the findings to `note`; `extent` is `outside` (external validators too) or `gate`."""
    findings = validate_file(Path(file), external=extent == "outside")
    write_atomically(Path(note), json.dumps([d.model_dump(mode="json") for d in findings]).encode())


if __name__ == "__main__":
    main(*sys.argv[1:4])
