"""Edge-connected components of a triangle mesh: label of each face, area, volume, box, closedness, winding, nesting.

From welded points (n, 3) and triangles (m, 3); lengths in the unit of the points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from geom.mesh.edges import Edges, edges_of, face_components
from geom.mesh.surface_distance import NearestOnSurface, triangle_areas
from geom.mesh.winding_number import winding_numbers
from schemas.arrays import BoolArray, FloatArray, IntArray

# Points of a component that are tested for lying inside another one.
INSIDE_PROBES = 8
# Above this many pairs of point and triangle the parity of rays replaces the winding number.
MAX_SOLID_ANGLES = 20_000_000
# Volume over area ** 1.5 below which a closed surface encloses only rounding; a ball has 0.094.
MIN_COMPACTNESS = 1e-7


@dataclass(frozen=True)
class Components:
    """`k` components of a triangle mesh, in order of their first face.

    label      (m,) component of each face.
    faces      (k,) number of faces.
    area       (k,) surface area.
    volume     (k,) signed volume about the component's own centre; meaningful where `closed` and `consistent`.
    low, high  (k, 3) bounding boxes.
    closed     (k,) every edge has an even number of faces.
    consistent (k,) no edge with two faces has both half-edges in one direction; in closed components all cancel.
    boundary   (k,) boundary edges.
    """

    label: IntArray
    faces: IntArray
    area: FloatArray
    volume: FloatArray
    low: FloatArray
    high: FloatArray
    closed: BoolArray
    consistent: BoolArray
    boundary: IntArray

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.faces)

    @property
    def solid(self) -> BoolArray:
        """(k,) True where closed and consistently wound, so that `volume` is defined."""
        return self.closed & self.consistent

    @property
    def inside_out(self) -> BoolArray:
        """(k,) True where solid with a negative volume beyond rounding; a double-sided sheet has none."""
        return self.solid & (self.volume < -MIN_COMPACTNESS * self.area**1.5)

    @property
    def extent(self) -> FloatArray:
        """(k,) bounding-box diagonals."""
        return np.linalg.norm(self.high - self.low, axis=1)


def components_of(points: FloatArray, triangles: IntArray, edges: Edges | None = None) -> Components:
    """Measure the components of welded triangles, none of which may repeat an index."""
    edges = edges or edges_of(triangles)
    count, label = face_components(edges)
    edge_label = np.zeros(len(edges.uses), dtype=np.int64)
    edge_label[edges.of_face.reshape(-1)] = np.repeat(label, 3)
    corners = points[triangles]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    centred = corners - (0.5 * (low + high))[label][:, None, :]
    volumes = np.einsum("ij,ij->i", centred[:, 0], np.cross(centred[:, 1], centred[:, 2])) / 6.0

    def per_component(marked_edges: BoolArray) -> IntArray:
        return np.bincount(edge_label[marked_edges], minlength=count)

    closed = per_component(edges.uses % 2 == 1) == 0
    crossed = (edges.uses == 2) & (edges.net != 0)
    unbalanced = (edges.uses % 2 == 0) & (edges.net != 0)
    balanced, uncrossed = per_component(unbalanced) == 0, per_component(crossed) == 0
    return Components(
        label=label,
        faces=np.bincount(label, minlength=count),
        area=np.bincount(label, triangle_areas(corners), count).astype(np.float64, copy=False),
        volume=np.bincount(label, volumes, count).astype(np.float64, copy=False),
        low=low,
        high=high,
        closed=closed,
        consistent=cast(BoolArray, np.where(closed, balanced, uncrossed)),
        boundary=per_component(edges.uses == 1),
    )


def opposite_container(
    points: FloatArray, triangles: IntArray, parts: Components, volume: FloatArray | None = None
) -> IntArray:
    """For each component (k,): the smallest closed component that contains it and is oppositely wound, or -1.

    An inner shell with such a container is a cavity: the outer shell is wound outward, the inner one inward.
    Containment compares bounding boxes, then the winding number at up to eight points. `volume` (k,) are signed
    volumes, zero where a component encloses none; by default those of the solid ones. A surface with small holes still
    winds about points inside it.
    """
    volume = np.where(parts.solid, parts.volume, 0.0) if volume is None else volume
    parent = np.full(parts.count, -1, dtype=np.int64)
    inward, outward = np.flatnonzero(volume < 0.0), np.flatnonzero(volume > 0.0)
    few, many = sorted(
        (inward, outward), key=len
    )  # Pairs are searched from the smaller set: most files have no cavity.
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for part in few:
        around = (parts.low[many] < parts.low[part]).all(axis=1) & (parts.high[many] > parts.high[part]).all(axis=1)
        within = (parts.low[many] > parts.low[part]).all(axis=1) & (parts.high[many] < parts.high[part]).all(axis=1)
        pairs += [np.stack(np.broadcast_arrays(many[around], part), axis=1)]
        pairs += [np.stack(np.broadcast_arrays(part, many[within]), axis=1)]
    outer_inner = np.concatenate(pairs)
    outers = np.unique(outer_inner[:, 0])
    groups = np.split(np.argsort(parts.label, kind="stable"), np.cumsum(parts.faces)[:-1])
    for outer in outers[np.argsort(-np.abs(volume[outers]), kind="stable")]:
        inners = np.sort(outer_inner[outer_inner[:, 0] == outer, 1])
        probes = [_spread(np.unique(triangles[groups[inner]])) for inner in inners]
        inside = _inside(points[np.concatenate(probes)], points, triangles[groups[outer]])
        first = np.cumsum([0, *(len(p) for p in probes)])[:-1]
        parent[inners[np.logical_and.reduceat(inside, first)]] = outer
    return parent


def _spread(points: IntArray) -> IntArray:
    """Up to `INSIDE_PROBES` of the point indices (k,), at even steps."""
    return points[np.linspace(0, len(points) - 1, min(INSIDE_PROBES, len(points))).astype(np.int64)]


def _inside(probes: FloatArray, points: FloatArray, triangles: IntArray) -> BoolArray:
    """(k,) True for probes (k, 3) inside the surface, by winding numbers or, where these are slow, by ray parity."""
    if len(probes) * len(triangles) <= MAX_SOLID_ANGLES:
        return np.abs(winding_numbers(probes, points[triangles])) > 0.5
    return NearestOnSurface(points, triangles).inside(probes)
