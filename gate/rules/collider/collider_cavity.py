"""Rule: colliders keep the openings and containers of the visible surface, tested with a probe ball."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import hull_of
from gate.subject.values import at
from gate.subject.whole_surface import count_edges
from geom.convex.hull import volume
from geom.decomposition.fidelity import measure_fidelity
from geom.features.cavities import find_cavities
from geom.mesh.weld import weld_points
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding
from schemas.physics import CollisionShape, Solid

CODE = DiagnosticCode(
    "asset/gate-collider-cavity",
    "Colliders close an opening, or let out what lies in it",
    "A mug takes nothing, or loses what is put into it.",
    "decompose the collision shape around the opening, or ingest the source again",
    severity="warning",
)
MOST_POURED_TRIANGLES = 100_000  # Pouring takes about a second for so many.
FULL = 0.95  # A body that fills its hull by this share has no cavity worth testing.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body into whose openings a ball of 60 % of their width goes, but not past its colliders.

    Also for a container whose colliders let the ball out at the side or below. Only for closed surfaces: what an open
    one contains depends on missing walls. A warning, for a wider ball or another way may still go in.
    """
    if not subject.released:
        return
    for body in subject.active_bodies:
        solid, hulls = _visible_solid(body), [c.hull_W for c in body.active_colliders]
        convex_hulls = [h for h in hulls if h is not None]
        if solid is None or not convex_hulls:
            continue
        shapes = [
            CollisionShape("hull", (), np.eye(4), body.in_body(h.points), h.triangles.astype(np.int32))
            for h in convex_hulls
        ]
        cavities = find_cavities(solid)
        lost = [c for c in cavities if measure_fidelity("", shapes, solid, [c]).cavity_kept is False]
        if lost:
            yield finding(
                CODE,
                "the colliders close an opening, or let out what lies in it",
                where=at(body.prim),
                value=len(lost),
                bound=0,
                unit=f"of {len(cavities)} openings",
            )


def _visible_solid(body: Body) -> Solid | None:
    """The visible surface in the body frame, one mesh; None when it is open, heavy, or as full as its hull."""
    edges, hull = count_edges(body.surfaces), hull_of(body.visible_points_W)
    drawn = [s for s in body.surfaces if len(s.triangles)]
    if edges is None or edges.open or hull is None or sum(len(s.triangles) for s in drawn) > MOST_POURED_TRIANGLES:
        return None
    first = np.cumsum([0, *(len(s.points_W) for s in drawn)])
    points, triangles = weld_points(
        body.in_body(np.concatenate([s.points_W for s in drawn])),
        np.concatenate([s.triangles + start for s, start in zip(drawn, first[:-1], strict=True)]),
    )
    if volume(points, triangles) > FULL * hull.volume.volume_m3:
        return None
    return Solid(points, triangles.astype(np.int32), "closed")


RULE = Rule(
    CODE,
    "a ball of 60 % of the opening goes in as in the visible surface, and stays in (packages, closed surfaces)",
    "filling of depressions (Planchon and Darboux 2002) and a probe ball, as for the choice of colliders",
    check,
)
