"""Edge counts of the visible surface of an asset, welded into one mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gate.subject.body import VisibleSurface
from geom.mesh.edges import edges_of
from geom.mesh.topology import repeats_point
from geom.mesh.weld import weld_points

MOST_COUNTED_TRIANGLES = 500_000  # A heavier file is not counted.


class EdgeCounts(NamedTuple):
    """Edges of the visible meshes together, equal points merged, as `geom.mesh.topology.observe` counts them.

    open          edges with one face.
    inconsistent  edges through which two faces run in the same direction.
    """

    all: int
    open: int
    inconsistent: int


def count_edges(surfaces: Sequence[VisibleSurface]) -> EdgeCounts | None:
    """The counts; None when nothing is visible or there is too much of it."""
    drawn = [s for s in surfaces if len(s.triangles) and np.all(np.isfinite(s.points_W))]
    if not drawn or sum(len(s.triangles) for s in drawn) > MOST_COUNTED_TRIANGLES:
        return None
    first = np.cumsum([0, *(len(s.points_W) for s in drawn)])
    points = np.concatenate([s.points_W for s in drawn])
    triangles = np.concatenate([s.triangles + start for s, start in zip(drawn, first[:-1], strict=True)])
    _, triangles = weld_points(points, triangles)
    edges = edges_of(triangles[~repeats_point(triangles)])
    crossed = int(((edges.uses == 2) & (edges.net != 0)).sum())
    return EdgeCounts(len(edges.uses), int((edges.uses == 1).sum()), crossed)
