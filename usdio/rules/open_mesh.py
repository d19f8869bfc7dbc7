"""Rule: a visible surface has the holes it was released with, and no others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geom.edges import edges_of
from geom.topology import repeats_point
from geom.weld import weld_points
from schemas.diagnostics import Diagnostic, Severity, finding
from usdio.rules.rule import Rule
from usdio.subject import Subject
from usdio.subject.values import at

CODE = "asset/gate-open-mesh"
MOST_TRIANGLES = 500_000
NEARLY_CLOSED = 0.02  # share of edges with one face: below, a sheet was hardly meant


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when more edges of the visible surface have one face only than the record counts.

    Without a record an open surface may be meant (leaves, cloth, bowls of no thickness), so that only a few holes in an
    otherwise closed surface are worth a warning.
    """
    surfaces = [s for s in subject.surfaces if len(s.triangles) and np.all(np.isfinite(s.points_W))]
    if not surfaces or sum(len(s.triangles) for s in surfaces) > MOST_TRIANGLES:
        return
    first = np.cumsum([0, *(len(s.points_W) for s in surfaces)])
    points = np.concatenate([s.points_W for s in surfaces])
    triangles = np.concatenate([s.triangles + start for s, start in zip(surfaces, first[:-1], strict=True)])
    _, triangles = weld_points(points, triangles)
    edges = edges_of(triangles[~repeats_point(triangles)])
    rims = int((edges.uses == 1).sum())
    released = _released_rims(subject)
    if released is not None:
        if rims > released + 0.01 * released:
            headline = "the visible surface has holes it was not released with"
            yield finding(CODE, headline, where=at(subject.root), value=rims, bound=released, unit="open edges")
    elif 0 < rims < NEARLY_CLOSED * len(edges.uses):
        headline = "the visible surface is closed but for a few holes"
        severity = Severity.WARNING if subject.released else Severity.INFO
        yield finding(CODE, headline, where=at(subject.root), value=rims, bound=0, unit="open edges", severity=severity)


def _released_rims(subject: Subject) -> int | None:
    try:
        return int((subject.record or {})["geometry"]["reobserved"]["boundary_edges"])
    except (KeyError, TypeError, ValueError):
        return None


RULE = Rule(CODE, "no more open edges than in record.json", "AssetRecord geometry.reobserved; edge-manifoldness", check)
