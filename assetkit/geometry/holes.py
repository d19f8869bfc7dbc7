"""The edit that fills holes of a mesh, except T-junction cracks and holes that another part is fitted into."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from assetkit.geometry.edit import Edit, EditContext
from geom.mesh.components import components_of
from geom.mesh.edges import edges_of
from geom.mesh.surface_distance import NearestOnSurface, triangle_areas
from geom.mesh.weld import diagonal, weld
from geom.repair.boundary_loops import OpenBody, Opening, classify_open_bodies
from geom.repair.fill_uncertainty import ShapeUncertainty
from geom.repair.holes import fill_openings
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

# A loop this thin (area over squared perimeter; a circle has 0.08) and this narrow (mean width over the diagonal) is a
# T-junction, not a hole.
CRACK_THINNESS, CRACK_WIDTH = 2e-3, 1e-3
# An eye in its socket, a dial in its housing: gap between the rim and the other part, over the hole's mean radius.
FITTED_GAP = 0.1
# A rim of more points is no missing face or two: it may be the mouth of a vessel, which goes on as smoothly as a hole.
MOST_RIM_POINTS = 10


def fill_holes(item: EditContext) -> Edit:
    """Holes in nearly closed surfaces. The uncertainty is that of the cap that may be furthest off.

    An opening with a rim of many points may be meant: then all of its cap is wrong, up to its radius.
    """
    mesh = item.mesh
    edges = edges_of(mesh.triangles)
    parts = components_of(mesh.points, mesh.triangles, edges)
    bodies = [b for b in classify_open_bodies(mesh.points, mesh.triangles, edges, parts) if b.kind == "holes"]
    holes = _true_holes(bodies, item) if bodies else []
    if not holes:
        return Edit(mesh)
    filled, figures, uncertainties = fill_openings(mesh, holes)
    looped = sum(len(o.points) for o in holes)
    boundary = int((edges.uses == 1).sum())
    return Edit(
        weld(filled),
        {"holes": len(holes), "boundary_edges": boundary, "filled_area_m2": 0.0},
        {"holes": 0, "boundary_edges": boundary - looped, "filled_area_m2": figures["filled_area"]},
        max([*uncertainties, *_mouths(mesh, holes)], key=lambda uncertainty: uncertainty.length),
    )


def _mouths(mesh: Mesh, holes: Sequence[Opening]) -> list[ShapeUncertainty]:
    """For each opening that may be a mouth the radius of a disc of its area."""
    return [
        ShapeUncertainty(float(np.sqrt(o.area / np.pi)), mesh.points[o.points].mean(axis=0))
        for o in holes
        if len(o.points) > MOST_RIM_POINTS
    ]


def _true_holes(bodies: Sequence[OpenBody], item: EditContext) -> list[Opening]:
    """The openings of `bodies` that are no cracks and that nothing is fitted into."""
    mesh = item.mesh
    rest = np.ones(len(mesh.triangles), dtype=bool)
    for body in bodies:
        rest[body.faces] = False
    open_surfaces = [_FittedSurface(mesh.points, mesh.triangles[body.faces]) for body in bodies]
    other_surfaces = [_FittedSurface(mesh.points, mesh.triangles[rest]), _FittedSurface(*item.others)]
    return [
        opening
        for i, body in enumerate(bodies)
        for opening in body.openings
        if not _is_crack(opening, mesh)
        and not _is_fitted(opening, mesh, [*other_surfaces, *open_surfaces[:i], *open_surfaces[i + 1 :]])
    ]


class _FittedSurface:
    """A surface that may be fitted into a hole; its search tree is made when it is first needed."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        self.points, self.triangles = points, triangles[triangle_areas(points[triangles]) > 0.0]
        used = points[self.triangles].reshape(-1, 3)
        self.low, self.high = (used.min(axis=0), used.max(axis=0)) if len(used) else (np.inf, -np.inf)

    @cached_property
    def nearest(self) -> NearestOnSurface:
        return NearestOnSurface(self.points, self.triangles)

    def is_near(self, rim: FloatArray, reach: float) -> bool:
        """True iff half of the rim lies within `reach` of the surface."""
        if (rim.min(axis=0) - reach > self.high).any() or (rim.max(axis=0) + reach < self.low).any():
            return False
        return float(np.median(np.linalg.norm(self.nearest(rim)[0] - rim, axis=1))) <= reach


def _is_crack(opening: Opening, mesh: Mesh) -> bool:
    rim = mesh.points[opening.points]
    perimeter = float(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1).sum())
    narrow = 2.0 * opening.area < CRACK_WIDTH * diagonal(mesh.points) * perimeter
    return narrow and opening.area < CRACK_THINNESS * perimeter**2


def _is_fitted(opening: Opening, mesh: Mesh, around: Sequence[_FittedSurface]) -> bool:
    """True iff another part is fitted into the hole: half of the rim lies within a tenth of its radius of that part."""
    reach = FITTED_GAP * float(np.sqrt(opening.area / np.pi))
    return any(part.is_near(mesh.points[opening.points], reach) for part in around)
