"""Protrusions of a surface: parts much thinner than the body from which they extend, such as handles and spouts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geom.features.regions import FaceGeometry, SurfaceRegion, face_geometry
from geom.features.shape_diameter import faces_in_openings, shape_diameter
from geom.mesh.decimate import decimate
from geom.mesh.edges import Edges, edges_of
from geom.mesh.surface_distance import NearestOnSurface
from geom.mesh.topology import repeats_point
from schemas.arrays import BoolArray, FloatArray

_FACES = 3000  # Thickness needs no more; the regions are carried back to all triangles.
_LEAST_LOG_STEP = np.log(2.0)  # A hand closes around a protrusion, and not around the body.
_LEAST, _MOST = 0.01, 0.5  # share of one protrusion in the surface: a larger part is the body
_LONGER = 2.0  # times as long as thick: a stub is no protrusion
_MAX_COUNT = 4
_SMOOTHED = 3


def find_protrusions(surface: FaceGeometry, openings: Sequence[FloatArray] = ()) -> tuple[SurfaceRegion, ...]:
    """Protrusions, the larger first: `loop` if joined to the body twice, `arm` if once; at most four.

    `openings` (3,) are directions out of cavities, whose inside counts as solid.
    """
    welded = face_geometry(*decimate(surface.points, surface.triangles, _FACES))
    light = face_geometry(welded.points, welded.triangles[~repeats_point(welded.triangles)])
    if len(light.triangles) == 0 or light.area.sum() <= 0.0:
        return ()
    inner, edges = faces_in_openings(light, openings), edges_of(light.triangles)
    thick = np.log(np.maximum(shape_diameter(light, inner), 1e-6 * float(np.linalg.norm(light.extent))))
    thick = _smoothed(thick, edges)
    bound = _threshold(thick, light.area * ~inner)
    if bound is None:
        return ()
    thin = (thick < bound) & ~inner
    protrusions: list[tuple[float, SurfaceRegion, BoolArray]] = []
    for part in light.pieces(thin):
        share = light.area[part].sum() / light.area.sum()
        long = float(np.linalg.norm(np.ptp(light.middle[part], axis=0)))
        if not _LEAST < share < _MOST or long < _LONGER * float(np.exp(np.median(thick[part]))):
            continue
        joints = _joints(light, part, edges)
        if joints:
            protrusions.append((float(share), SurfaceRegion("loop" if joints > 1 else "arm", part), part))
    if not 1 <= len(protrusions) <= _MAX_COUNT:
        return ()
    protrusions.sort(key=lambda f: (-round(f[0], 9), int(np.argmax(f[2]))))
    _, nearest = NearestOnSurface(light.points, light.triangles)(surface.middle)
    return tuple(SurfaceRegion(region.role, part[nearest]) for _, region, part in protrusions)


def _smoothed(values: FloatArray, edges: Edges) -> FloatArray:
    """Means over a triangle and its neighbours, a few times: single rays meet notches and seams."""
    faces = np.arange(len(values))
    sides = csr_array((np.ones(3 * len(faces)), (np.repeat(faces, 3), edges.of_face.ravel())))
    links = sides @ sides.T
    links.setdiag(1.0)
    number = np.asarray(links.sum(axis=1)).ravel()
    for _ in range(_SMOOTHED):
        values = (links @ values) / number
    return values


def _threshold(thick: FloatArray, weight: FloatArray) -> float | None:
    """Threshold between two classes of log thickness (Otsu 1979); None when they differ by less than a factor 2."""
    counts, edges = np.histogram(thick, 64, weights=weight)
    middles = 0.5 * (edges[1:] + edges[:-1])
    below, above = np.cumsum(counts)[:-1], np.cumsum(counts[::-1])[::-1][1:]
    if not (below.any() and above.any()):
        return None
    low = np.cumsum(counts * middles)[:-1] / np.maximum(below, 1e-300)
    high = np.cumsum((counts * middles)[::-1])[::-1][1:] / np.maximum(above, 1e-300)
    best = int(np.argmax(below * above * (high - low) ** 2))
    return float(0.5 * (low[best] + high[best])) if high[best] - low[best] >= _LEAST_LOG_STEP else None


def _joints(surface: FaceGeometry, part: BoolArray, edges: Edges) -> int:
    """Number of separate places where a part joins the rest, by the rings of edges between them."""
    inside = np.bincount(edges.of_face[part].ravel(), minlength=len(edges.uses))
    ring = edges.points[(inside > 0) & (inside < edges.uses)]
    if len(ring) == 0:
        return 0
    count = len(surface.points)
    links = coo_array((np.ones(len(ring)), (ring[:, 0], ring[:, 1])), shape=(count, count))
    _, label = connected_components(links, directed=False)
    length = np.linalg.norm(surface.points[ring[:, 1]] - surface.points[ring[:, 0]], axis=1)
    rings = np.bincount(label[ring[:, 0]], length)
    return int((rings > 0.2 * rings.max()).sum())
