"""Rule: visible surfaces are wound outwards."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject, VisibleSurface
from gate.subject.body import diagonal
from gate.subject.values import at
from geom.convex.penetration import even_directions
from geom.mesh.edges import edges_of
from geom.mesh.topology import repeats_point
from geom.mesh.weld import weld_points
from geom.repair.sheet_orientation import SkyVisibility
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-inverted-mesh",
    "A visible surface is inside out",
    "Back-face culling makes it vanish; rays and volumes change sign.",
    "reverse the winding of the faces, or the orientation of the mesh",
)
SIGHT_DIRECTIONS = 64
LEAST_VOTES, LEAST_OUTWARD_SHARE = 8, 0.2
MOST_VIEWED_TRIANGLES, MOST_VOTERS = 300_000, 1_000_000  # for the closedness test, for the vote


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per mesh that shows the inside of its faces.

    Two tests. Where the mesh is the outermost thing in some direction, its faces there must face that way: a vote
    over 64 directions, which also works for open surfaces. And a closed mesh that is not inside another one must
    hold a positive volume. Where the vote is lost by a sheet that shows nearly as much of one side as of the other
    (`geom.repair.sheet_orientation`: a dish, a vault) either may be meant: a warning.
    """
    surfaces = [s for s in subject.surfaces if len(s.triangles) and np.all(np.isfinite(s.points_W))]
    if sum(len(s.triangles) for s in surfaces) > MOST_VOTERS:
        return
    for surface, (votes, share) in zip(surfaces, _outward_votes(surfaces), strict=True):
        outvoted = votes >= LEAST_VOTES and share < LEAST_OUTWARD_SHARE
        if (
            outvoted
            and not SkyVisibility(surface.points_W, surface.triangles).of_sheet(surface.triangles).is_inside_out
        ):
            yield finding(
                CODE,
                "the mesh may be inside out: its faces look inwards, but neither side is clearly its outside",
                where=at(surface.prim),
                value=share,
                bound=LEAST_OUTWARD_SHARE,
                severity=Severity.WARNING,
            )
        elif outvoted or (votes < LEAST_VOTES and _encloses_nothing(surface, surfaces)):
            yield finding(
                CODE,
                "the mesh is inside out: its faces look inwards",
                where=at(surface.prim),
                value=share,
                bound=LEAST_OUTWARD_SHARE,
                severity=subject.suspect_severity,
            )
    edges, released = subject.visible_edges, subject.record_value("geometry", "reobserved", "inconsistent_edges")
    if edges is not None and isinstance(released, int) and edges.inconsistent > released:
        headline, count = "neighbouring faces look to opposite sides", edges.inconsistent
        yield finding(CODE, headline, where=at(subject.root), value=count, bound=released, unit="edges")


def _outward_votes(surfaces: list[VisibleSurface]) -> list[tuple[int, float]]:
    """Per surface: the number of directions in which it alone is outermost, and the share of these in which its faces
    face outwards."""
    if not surfaces:
        return []
    directions = even_directions(SIGHT_DIRECTIONS)
    heights = [_heights(s, directions) for s in surfaces]
    support = np.stack([height.max(axis=0) for height in heights])
    size = diagonal(np.concatenate([s.points_W for s in surfaces]))
    outermost = support >= support.max(axis=0) - 1e-6 * size
    outermost &= outermost.sum(axis=0) == 1  # Some modellers lay a reversed copy onto a sheet, to show both sides.
    votes = []
    for surface, height, alone, top in zip(surfaces, heights, outermost, support, strict=True):
        touching = height[:, alone] >= top[alone] - 1e-4 * size
        outward = _outward_areas(surface, touching, directions[alone])
        decided = outward[outward != 0.0]
        votes.append((len(decided), float((decided > 0.0).mean()) if len(decided) else 1.0))
    return votes


def _heights(surface: VisibleSurface, directions: np.ndarray) -> np.ndarray:
    """(n, k) how far each point lies along each direction; -inf for points without a face."""
    used = np.zeros(len(surface.points_W), dtype=bool)
    used[surface.triangles] = True
    heights = surface.points_W @ directions.T
    heights[~used] = -np.inf
    return heights


def _outward_areas(surface: VisibleSurface, touching: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(k,) for each direction the area, seen along it, of the faces at the outermost points; 0 when they cancel.

    touching  (n, k) which of the surface's points are outermost in direction k.
    """
    at_top = np.asarray(touching.any(axis=1))
    outer = surface.triangles[at_top[surface.triangles].any(axis=1)]
    a, b, c = np.moveaxis(surface.points_W[outer], 1, 0)
    area = np.cross(b - a, c - a)
    outward = np.zeros(len(directions))
    for k, direction in enumerate(directions):
        seen = area[touching[:, k][outer].any(axis=1)] @ direction
        total = float(seen.sum())
        outward[k] = total if abs(total) > 0.2 * float(np.abs(seen).sum()) else 0.0
    return outward


def _encloses_nothing(surface: VisibleSurface, surfaces: list[VisibleSurface]) -> bool:
    """True for a closed mesh of negative volume that no other mesh's bounds contain (there it could be a cavity)."""
    if len(surface.triangles) > MOST_VIEWED_TRIANGLES:
        return False
    low, high = surface.points_W.min(axis=0), surface.points_W.max(axis=0)
    for other in surfaces:
        if other is not surface:
            around = np.all(other.points_W.min(axis=0) <= low) and np.all(other.points_W.max(axis=0) >= high)
            if around:
                return False
    points, triangles = weld_points(surface.points_W, surface.triangles)
    triangles = triangles[~repeats_point(triangles)]
    edges = edges_of(triangles)
    if len(triangles) == 0 or np.any(edges.uses != 2) or np.any(edges.net != 0):
        return False
    a, b, c = np.moveaxis(points[triangles] - points.mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) < 0.0


RULE = Rule(
    CODE,
    "outermost faces look outwards in 20 % of 64 directions or more; no more turned edges than in record.json",
    "SimReady VG.029; support mapping",
    check,
)
