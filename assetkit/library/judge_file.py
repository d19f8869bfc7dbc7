"""Judge one USD asset: outside validators and gate. Also the entry point of a cell that does so."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

from gate.external_validators import SIMREADY, Verdict, outside_verdicts
from gate.static_gate import claims_release, gate
from jobs.cache import write_atomically
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from usdio.read.usdz import check_package

_RANK = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.INFO: 2}


def judge(file: Path, *, outside: bool = True) -> tuple[Diagnostic, ...]:
    """All findings of the outside validators (unless `outside` is False) and of the gate, gravest first.

    One finding when the file cannot be opened, or is an archive that no reader should open. What SimReady asks of a
    package is `info` for a file that does not claim to be one.
    """
    try:
        if file.suffix.lower() == ".usdz":
            check_package(file, where=Location(file=file.name))
        verdicts = outside_verdicts(file) if outside else ()
    except InvalidInput as unreadable:
        return (unreadable.diagnostic,)
    found = [d for verdict in verdicts for d in _said(verdict, file)]
    return tuple(sorted([*found, *gate(file)], key=lambda d: _RANK[d.severity]))


def _said(verdict: Verdict, file: Path) -> Iterator[Diagnostic]:
    claimed = verdict.judge != SIMREADY or claims_release(file)
    code = "asset/simready-rule" if verdict.judge == SIMREADY else "asset/usd-rule"
    for severity, remarks in (
        (Severity.ERROR if claimed else Severity.INFO, verdict.findings),
        (Severity.WARNING if claimed else Severity.INFO, verdict.warnings),
    ):
        for remark in remarks:
            where = Location(prim=remark.prim) if remark.prim else Location(file=file.name)
            yield finding(code, str(remark), where=where, severity=severity)


def main(file: str, note: str, extent: str) -> None:
    """Judge `file` and leave the findings in `note`; `extent` is `outside` or `gate`."""
    found = judge(Path(file), outside=extent == "outside")
    write_atomically(Path(note), json.dumps([d.model_dump(mode="json") for d in found]).encode())


if __name__ == "__main__":
    main(*sys.argv[1:4])
