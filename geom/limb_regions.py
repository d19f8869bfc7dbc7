"""Limbs of a body in one piece: what is much thinner than the rest and sticks out of it, such as handles and spouts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geom.decimate import decimate
from geom.shape_diameter import shape_diameter, wet
from geom.shape_regions import Faces, Region, faces_of
from geom.surface_distance import NearestOnSurface
from schemas.model import FloatArray, IntArray

_FACES = 3000  # Thickness needs no more; the regions are carried back to all triangles.
_THINNER = np.log(2.0)  # A hand closes around a limb, and not around the body.
_LEAST, _MOST = 0.01, 0.5  # share of the surface of one limb: more is no limb but the body
_LONGER = 2.0  # times as long as thick: a stub is no limb
_MOST_LIMBS = 4
_SMOOTHED = 3


def limb_regions(surface: Faces, openings: Sequence[FloatArray] = ()) -> tuple[Region, ...]:
    """Limbs, the larger first: `loop` where the body is met twice, `arm` where once; at most four.

    `openings` (3,) are directions out of cavities, whose inside counts as full.
    """
    light = faces_of(*decimate(surface.points, surface.triangles, _FACES))
    if len(light.triangles) == 0 or light.area.sum() <= 0.0:
        return ()
    inner = wet(light, openings)
    pairs = _neighbours(light)
    thick = np.log(np.maximum(shape_diameter(light, inner), 1e-6 * float(np.linalg.norm(light.extent))))
    thick = _smoothed(thick, pairs, len(light.triangles))
    bound = _threshold(thick, light.area * ~inner)
    if bound is None:
        return ()
    thin = (thick < bound) & ~inner
    found: list[tuple[float, Region, IntArray]] = []
    for limb in _pieces(thin, pairs):
        share = light.area[limb].sum() / light.area.sum()
        long = float(np.linalg.norm(np.ptp(light.middle[limb], axis=0)))
        if not _LEAST < share < _MOST or long < _LONGER * float(np.exp(np.median(thick[limb]))):
            continue
        joints = _joints(light, limb)
        if joints:
            found.append((float(share), Region("loop" if joints > 1 else "arm", limb), limb))
    if not 1 <= len(found) <= _MOST_LIMBS:
        return ()
    found.sort(key=lambda f: (-round(f[0], 9), int(np.argmax(f[2]))))
    _, nearest = NearestOnSurface(light.points, light.triangles)(surface.middle)
    return tuple(Region(region.role, limb[nearest]) for _, region, limb in found)


def _neighbours(surface: Faces) -> IntArray:
    """(k, 2) triangles that share an edge."""
    sides = np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    same = (sides[order[1:]] == sides[order[:-1]]).all(axis=1)
    return np.column_stack([order[:-1][same] // 3, order[1:][same] // 3])


def _smoothed(values: FloatArray, pairs: IntArray, count: int) -> FloatArray:
    """Means over a triangle and its neighbours, a few times: single rays meet notches and seams."""
    ones = np.ones(len(pairs))
    links = csr_array(coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count)))
    links = links + links.T
    number = 1.0 + np.asarray(links.sum(axis=1)).ravel()
    for _ in range(_SMOOTHED):
        values = (values + links @ values) / number
    return values


def _threshold(thick: FloatArray, weight: FloatArray) -> float | None:
    """Where two classes of thickness part best (Otsu 1979), None when they differ by less than a factor of two."""
    counts, edges = np.histogram(thick, 64, weights=weight)
    middles = 0.5 * (edges[1:] + edges[:-1])
    below, above = np.cumsum(counts)[:-1], np.cumsum(counts[::-1])[::-1][1:]
    if not (below.any() and above.any()):
        return None
    low = np.cumsum(counts * middles)[:-1] / np.maximum(below, 1e-300)
    high = np.cumsum((counts * middles)[::-1])[::-1][1:] / np.maximum(above, 1e-300)
    best = int(np.argmax(below * above * (high - low) ** 2))
    return float(0.5 * (low[best] + high[best])) if high[best] - low[best] >= _THINNER else None


def _pieces(chosen: IntArray, pairs: IntArray) -> list[IntArray]:
    """Masks (m,) of the pieces of the triangles `chosen` (m,) that hang together."""
    own = pairs[chosen[pairs].all(axis=1)]
    links = coo_array((np.ones(len(own)), (own[:, 0], own[:, 1])), shape=(len(chosen), len(chosen)))
    _, label = connected_components(links, directed=False)
    numbers, sizes = np.unique(label[chosen], return_counts=True)
    return [(label == n) & chosen for n in numbers[sizes > 1]]


def _joints(surface: Faces, limb: IntArray) -> int:
    """In how many separate places a limb meets the rest, by the rings of edges between them."""
    sides = np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, which = np.unique(sides, axis=0, return_inverse=True)
    owner = np.repeat(limb, 3)
    inside, outside = (
        np.bincount(which[owner], minlength=len(unique)),
        np.bincount(which[~owner], minlength=len(unique)),
    )
    ring = unique[(inside > 0) & (outside > 0)]
    if len(ring) == 0:
        return 0
    count = len(surface.points)
    links = coo_array((np.ones(len(ring)), (ring[:, 0], ring[:, 1])), shape=(count, count))
    _, label = connected_components(links, directed=False)
    length = np.linalg.norm(surface.points[ring[:, 1]] - surface.points[ring[:, 0]], axis=1)
    rings = np.bincount(label[ring[:, 0]], length)
    return int((rings > 0.2 * rings.max()).sum())
