"""Boundary loops of open surfaces (n, 3), (m, 3), and their class: hole to fill, mouth of a container, or sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geom.mesh.components import Components
from geom.mesh.edges import Edges
from geom.mesh.loop_triangulation import continued_faces, triangulate_loop, unit_normals
from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray, IntArray

OpeningKind = Literal["holes", "container", "sheet"]

# A loop this small against the cross-section behind it is a hole, whatever its shape.
PINHOLE_SHARE = 0.02
# Up to this share a loop is a hole when the surface around it lies in its plane (a gap in a wall) ...
HOLE_SHARE = 0.25
SLIT_AREA_SHARE = 2e-4
# ... which is measured as the mean cosine between the loop's normal and the normals of the faces along it.
FLUSH_COSINE = 0.5
MIN_AREA_SHARE = 1e-3
# One missing triangle is recognised by its three edges up to this share of the closed area.
TRIANGLE_AREA_SHARE = 0.15
COARSE_EDGES, COARSE_AREA_SHARE = 10, 0.25
SMOOTH_BEND_RAD = float(np.radians(30.0))
# All holes together may make up this share of the closed area; beyond, too little of the surface is known.
FILLED_AREA_SHARE = 0.3
# Capped volume over closed area ** 1.5 (a ball has 0.094): below, the surface is a sheet without a cavity ...
SHEET_COMPACTNESS = 0.015
# ... unless its openings are but this share of the closed area: then it is a thin-walled body, down to a card's volume.
NEARLY_CLOSED_SHARE = 0.1
CARD_COMPACTNESS = 5e-4
# A container's capped volume is most of its hull; less is a folded sheet or a cut-open body.
CONTAINER_HULL_SHARE = 0.7


@dataclass(frozen=True)
class Opening:
    """One boundary loop.

    points         (k,) point indices in the order that a cap's outer side needs, given the faces' winding.
    faces          (k,) the face at each loop edge (from points[i] to points[i + 1]).
    area           area of the loop's projection onto its mean plane (half the length of its vector area).
    section_share  `area` over the projected hull of the component on the same plane.
    flush_cosine   edge-length-weighted mean cosine between the loop's normal and the faces along it.
    """

    points: IntArray
    faces: IntArray
    area: float
    section_share: float
    flush_cosine: float


@dataclass(frozen=True)
class OpenBody:
    """One open component with its loops and its class `kind`.

    faces          (f,) face indices, ascending.
    complete       the loops use every boundary edge.
    capped_volume  signed volume once every loop is capped.
    """

    kind: OpeningKind
    faces: IntArray
    openings: tuple[Opening, ...]
    complete: bool
    area: float
    capped_volume: float


def classify_open_bodies(
    points: FloatArray, triangles: IntArray, edges: Edges, parts: Components
) -> tuple[OpenBody, ...]:
    """The class of every component that has boundary edges; the faces must be wound consistently beforehand.

    holes      every loop is a hole and together they are at most 30 % of the closed area (at most 10 % when the body is
               thin-walled, with a volume below 0.015 area ** 1.5): filled. A loop is one if
               (a) it has three edges and at most 15 % of the closed area, or
               (b) it spans at most 2 % of the component's cross-section parallel to it (in a thin-walled body also only
                   0.02 % of the closed area: the end of a wire is no hole), or
               (c) it spans at most 25 % and lies flush in the surface: the normals of the faces along it are,
                   on average, less than 60 degrees from the loop's normal. The open base patches of a scan are such
                   holes; the neck of a bottle is not, because its wall is perpendicular to the loop; or
               (d) it has at most 10 edges and 25 % of the closed area, and its cap continues the faces around it
                   without a bend of 30 degrees: missing sides of a coarse model.
    container  not `holes`, and capping every loop would enclose at least 70 % of the hull and a volume of at least
               0.015 area ** 1.5: there is a deep interior, and a mouth that belongs to the shape. Never to be filled.
    sheet      the rest: cards, planes, cloth, boards. Nothing to fill. Components with less than 0.1 % of the whole
               area are not examined and count as sheets without openings.
    """
    large_enough = parts.area >= MIN_AREA_SHARE * parts.area.sum()
    order = np.argsort(parts.label, kind="stable")
    groups = np.split(order, np.cumsum(parts.faces)[:-1])
    return tuple(
        _judge(points, triangles, edges, groups[part])
        if large_enough[part]
        else OpenBody("sheet", groups[part], (), False, float(parts.area[part]), 0.0)
        for part in np.flatnonzero(parts.boundary > 0)
    )


def boundary_loops(triangles: IntArray, edges: Edges, faces: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Loops of boundary edges of `faces`: points against the winding of the faces, and the face at each edge.

    Where several loops meet in one point they are separated at that point. Edges that cannot be chained are left out.
    """
    half = np.argwhere(edges.uses[edges.of_face[faces]] == 1)
    face = faces[half[:, 0]]
    start = triangles[face, (half[:, 1] + 1) % 3]  # Against the winding, so that a cap continues the surface.
    end = triangles[face, half[:, 1]]
    leaving: dict[int, list[int]] = {}
    for k in range(len(start) - 1, -1, -1):
        leaving.setdefault(int(start[k]), []).append(k)
    loops: list[tuple[IntArray, IntArray]] = []
    for first in range(len(start)):
        if first not in leaving.get(int(start[first]), ()):
            continue
        path = _trace(first, leaving, start, end)
        loops += [(start[loop], face[loop]) for loop in _simple_loops(path, start, end)]
    return loops


def _trace(first: int, leaving: dict[int, list[int]], start: IntArray, end: IntArray) -> list[int]:
    """Follow unused boundary half-edges from `first` until none leaves; they are removed from `leaving`."""
    path = [first]
    leaving[int(start[first])].remove(first)
    while leaving.get(int(end[path[-1]])):
        path.append(leaving[int(end[path[-1]])].pop())
    return path


def _simple_loops(path: list[int], start: IntArray, end: IntArray) -> list[IntArray]:
    """Cut a walk into loops that visit each point once; an open tail is dropped."""
    loops: list[IntArray] = []
    stack: list[int] = []
    at: dict[int, int] = {}
    for edge in path:
        at[int(start[edge])] = len(stack)
        stack.append(edge)
        if (entry := at.get(int(end[edge]))) is not None:
            loop, stack = stack[entry:], stack[:entry]
            for closed in loop:
                at.pop(int(start[closed]), None)
            if len(loop) >= 3:
                loops.append(np.array(loop))
    return loops


def _judge(points: FloatArray, triangles: IntArray, edges: Edges, faces: IntArray) -> OpenBody:
    body_points = points[np.unique(triangles[faces])]
    centre = 0.5 * (body_points.min(axis=0) + body_points.max(axis=0))
    corners = points[triangles[faces]] - centre
    outline = _extremes(body_points - centre)
    area = float(triangle_areas(corners).sum())
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)
    openings = tuple(_measure(points, triangles, outline, loop) for loop in boundary_loops(triangles, edges, faces))
    for opening in openings:
        rim = points[opening.points] - centre
        middle = rim.mean(axis=0)
        volume += float(np.einsum("ij,j->", np.cross(rim, np.roll(rim, -1, axis=0)), middle) / 6.0)
    closed_area = area + sum(o.area for o in openings)
    looped = sum(len(o.points) for o in openings)
    complete = looped == int((edges.uses[edges.of_face[faces]] == 1).sum())
    kind: OpeningKind = "sheet"
    nearly_closed = closed_area - area <= NEARLY_CLOSED_SHARE * closed_area
    compact = abs(volume) >= SHEET_COMPACTNESS * closed_area**1.5
    if complete and (compact or (nearly_closed and abs(volume) >= CARD_COMPACTNESS * closed_area**1.5)):
        few = closed_area - area <= FILLED_AREA_SHARE * closed_area
        if few and all(
            _is_hole(o, closed_area, compact) or _carries_on(o, points, triangles, closed_area) for o in openings
        ):
            kind = "holes"
        elif compact and abs(volume) >= CONTAINER_HULL_SHARE * _hull_volume(outline):
            kind = "container"
    return OpenBody(kind, faces, openings, complete, area, volume)


def _is_hole(opening: Opening, closed_area: float, compact: bool) -> bool:
    one_triangle = len(opening.points) == 3 and opening.area <= TRIANGLE_AREA_SHARE * closed_area
    flush = opening.section_share <= HOLE_SHARE and opening.flush_cosine >= FLUSH_COSINE
    pinhole = opening.section_share <= PINHOLE_SHARE and (compact or opening.area <= SLIT_AREA_SHARE * closed_area)
    return one_triangle or flush or pinhole


def _carries_on(opening: Opening, points: FloatArray, triangles: IntArray, closed_area: float) -> bool:
    if len(opening.points) > COARSE_EDGES or opening.area > COARSE_AREA_SHARE * closed_area:
        return False
    rim, normals = points[opening.points], unit_normals(points[triangles[opening.faces]])
    cap = triangulate_loop(rim, normals, np.zeros((len(rim), len(rim)), dtype=bool))
    if cap is None:
        return False
    return bool((continued_faces(rim, normals, np.arange(len(rim)), cap)[1] < SMOOTH_BEND_RAD).all())


def _measure(points: FloatArray, triangles: IntArray, outline: FloatArray, loop: tuple[IntArray, IntArray]) -> Opening:
    index, faces = loop
    rim = points[index]
    rim = rim - rim.mean(axis=0)
    vector_area = 0.5 * np.cross(rim, np.roll(rim, -1, axis=0)).sum(axis=0)
    area = float(np.linalg.norm(vector_area))
    if area == 0.0:
        return Opening(index, faces, 0.0, 0.0, 1.0)
    normal = vector_area / area
    corners = points[triangles[faces]]
    face_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face_normals /= np.maximum(np.linalg.norm(face_normals, axis=1, keepdims=True), np.finfo(float).tiny)
    lengths = np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)
    cosine = float(np.average(face_normals @ normal, weights=lengths))
    section = _projected_hull_area(outline, normal)
    return Opening(index, faces, area, area / section if section > 0.0 else 1.0, cosine)


def _extremes(points: FloatArray) -> FloatArray:
    """The extreme points (k, 3) in 400 even directions (Fibonacci lattice): a hull within about 1 % of area."""
    height = 1.0 - (2.0 * np.arange(400) + 1.0) / 400
    turn = np.arange(400) * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - height**2)
    directions = np.stack([radius * np.cos(turn), radius * np.sin(turn), height])
    return points[np.unique(np.argmax(points @ directions, axis=0))]


def _projected_hull_area(points: FloatArray, normal: FloatArray) -> float:
    basis = np.linalg.svd(normal[None])[2][1:]
    try:
        return float(ConvexHull(points @ basis.T).volume)  # In the plane, Qhull's "volume" is the area.
    except QhullError:
        return 0.0


def _hull_volume(points: FloatArray) -> float:
    try:
        return float(ConvexHull(points).volume)
    except QhullError:
        return np.inf
