"""Rule: the visible surface has no more open edges than its record counts."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-open-mesh",
    "A visible surface has holes it was not released with",
    "One looks through the object.",
    "restore the faces, or ingest the source again",
)
NEARLY_CLOSED = 0.02  # share of edges with one face: below, a sheet was hardly meant


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when more edges of the visible surface have one face only than the record counts.

    Without a record an open surface may be meant (leaves, cloth, bowls of no thickness), so that only a few holes in an
    otherwise closed surface are worth a warning.
    """
    edges, released = subject.visible_edges, subject.record_value("geometry", "reobserved", "boundary_edges")
    if edges is None:
        return
    if isinstance(released, int):
        if edges.open > released:
            headline = "the visible surface has holes it was not released with"
            yield finding(CODE, headline, where=at(subject.root), value=edges.open, bound=released, unit="open edges")
    elif 0 < edges.open < NEARLY_CLOSED * edges.all:
        headline = "the visible surface is closed but for a few holes"
        where, severity = at(subject.root), Severity.WARNING if subject.released else Severity.INFO
        yield finding(CODE, headline, where=where, value=edges.open, bound=0, unit="open edges", severity=severity)


RULE = Rule(CODE, "no more open edges than in record.json", "AssetRecord geometry.reobserved; edge-manifoldness", check)
