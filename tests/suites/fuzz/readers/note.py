"""What one reading of a damaged input gave: codes of findings, broken promises, the trace of an exception."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from schemas.codes import CODES
from schemas.diagnostics import Diagnostic

PATHS_AS_GIVEN = frozenset({"plan/missing-file"})  # the path is that of the command line


@dataclass
class Note:
    """`made` values came back; `codes` of all findings; `broken` promises; `trace` of an exception that is a bug."""

    made: int = 0
    codes: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    trace: str = ""

    def add(self, findings: Sequence[Diagnostic], folder: Path) -> None:
        """Take the codes of `findings`; none may be unknown, name an absolute path, or have an empty headline."""
        self.codes = sorted({*self.codes, *(d.code for d in findings)})
        for diagnostic in findings:
            if diagnostic.code not in CODES:
                self.broken.append(f"the code {diagnostic.code} has no row")
            if str(folder) in diagnostic.model_dump_json() and diagnostic.code not in PATHS_AS_GIVEN:
                self.broken.append(f"an absolute path in {diagnostic.code}: {diagnostic.headline}")
            if not diagnostic.headline.strip():
                self.broken.append(f"{diagnostic.code} has no headline")
