"""A proven cover of what convex shapes sweep while a joint moves: upright prisms (polygon in x and y, two heights).

Method. The range is cut into steps. Over a step of a turn by `d` a point runs on an arc, which lies in the triangle of
its ends and the meeting of the tangents there, at 1 / cos(d / 2) of its distance from the axis; a slide runs on the
chord itself. So the hull of these points of all corners of a shape contains the shape throughout the step, for every
point of the shape is a mixture of the corners with fixed weights. Each hull is cut into layers of height; in a layer it
lies over the hull of its corners there and of its edges' crossings with both faces of the layer. Metres, z up.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import ConvexHull, QhullError
from shapely.geometry.base import BaseGeometry

from geom.pose import apply
from schemas.arrays import FloatArray, IntArray

# A step of a turn: an arc of 7.5 degrees lies within 0.2 % of its radius of the triangle around it.
TURN_STEP_RAD = math.radians(7.5)
# Where only a bound on the speed is known: the way within a step, of the size of the body; steps at most.
BOUND_STEP, MOST_STEPS = 0.05, 200
HEIGHT_LAYERS = 24
# Outlines may gain this share of the object's size: what is rounded, and small detail, stays inside.
SPARE_SHARE = 4e-4
LEAST_SPARE_M = 2e-6  # above the rounding of single precision and of the record, for things of a few metres
MERGE_SHARE = 1e-3  # of the area: neighbouring layers that differ by less are one


@dataclass(frozen=True)
class Prism:
    """The points over `polygon` (x and y, metres) at heights from `low_m` to `high_m`."""

    polygon: shapely.Polygon
    low_m: float
    high_m: float


@dataclass(frozen=True)
class Sweep:
    """How a convex body with corners (n, 3) moves: `motion(q)` (4, 4) from where they are given, q over `limits`.

    `axis` and `anchor` (3,) of a turn, at the position where the corners are given; None for a slide. `exact`: the
    motion is one turn or one slide, else a bound on the speed of a corner, `speed` in metres per unit of q, is used.
    """

    corners: FloatArray
    motion: Callable[[float], FloatArray]
    limits: tuple[float, float]
    axis: FloatArray | None = None
    anchor: FloatArray | None = None
    exact: bool = True
    speed: float = 0.0


def swept_prisms(sweeps: Sequence[Sweep]) -> tuple[tuple[Prism, ...], float]:
    """Prisms whose union contains all that the bodies sweep, from the bottom up, and the volume (m3) of that union.

    The prisms do not overlap, so the volume is the sum of theirs.
    """
    of_sweep = [_hulls(sweep) for sweep in sweeps]
    hulls = [hull for swept in of_sweep for hull in swept]
    if not hulls:
        return (), 0.0
    points = np.concatenate([corners for corners, _ in hulls])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    spare = max(SPARE_SHARE * size, LEAST_SPARE_M)
    spans = [_heights(swept, spare) for swept in of_sweep]
    faces = _layer_faces(spans, spare)
    layers: list[tuple[BaseGeometry, float, float]] = []
    for low, high in itertools.pairwise(faces):
        outline = _outline(hulls, low, high, spare)
        if outline.is_empty:
            continue
        before = layers[-1] if layers else None
        if before is not None and before[2] == low and _alike(before[0], outline):
            layers[-1] = (shapely.union(before[0], outline), before[1], high)
        else:
            layers.append((outline, low, high))
    prisms = tuple(
        Prism(part, low, high)
        for outline, low, high in layers
        for part in shapely.get_parts(shapely.normalize(outline))
        if isinstance(part, shapely.Polygon) and part.area > 0.0
    )
    return prisms, float(sum(p.polygon.area * (p.high_m - p.low_m) for p in prisms))


def _hulls(sweep: Sweep) -> list[tuple[FloatArray, IntArray]]:
    """Corners (n, 3) and edges (k, 2) of convex bodies that together contain the sweep."""
    low, high = sweep.limits
    if not sweep.exact:
        size = float(np.linalg.norm(np.ptp(sweep.corners, axis=0)))
        count = math.ceil(sweep.speed * (high - low) / max(BOUND_STEP * size, 1e-9))
    elif sweep.axis is not None:
        high = min(high, low + 2.0 * math.pi)  # more than one turn sweeps no more
        count = math.ceil((high - low) / TURN_STEP_RAD - 1e-9)
    else:
        count = 1
    count = min(max(count, 1), MOST_STEPS)
    stations = np.linspace(low, high, count + 1)
    return [_hull(_within_step(sweep, float(a), float(b))) for a, b in itertools.pairwise(stations)]


def _within_step(sweep: Sweep, a: float, b: float) -> FloatArray:
    """Points (n, 3) whose hull contains the body at every position from `a` to `b`."""
    middle = apply(sweep.motion(0.5 * (a + b)), sweep.corners)
    if not sweep.exact:
        margin = sweep.speed * 0.5 * (b - a)
        signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
        return (middle[:, None] + margin * signs).reshape(-1, 3)
    ends = [apply(sweep.motion(q), sweep.corners) for q in (a, b)]
    if sweep.axis is None or sweep.anchor is None:
        return np.concatenate(ends)
    along = (middle - sweep.anchor) @ sweep.axis
    foot = sweep.anchor + along[:, None] * sweep.axis
    return np.concatenate([*ends, foot + (middle - foot) / math.cos(0.5 * (b - a))])


def _hull(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Corners and edges of the convex hull of points (n, 3); all pairs of points where they are flat."""
    try:
        hull = ConvexHull(points)
    except QhullError:
        box = np.array(list(itertools.product(*zip(points.min(axis=0), points.max(axis=0), strict=True))))
        return box, np.array(list(itertools.combinations(range(8), 2)))
    edges = np.sort(hull.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return points, np.unique(edges, axis=0)


def _heights(swept: Sequence[tuple[FloatArray, IntArray]], spare: float) -> tuple[float, float]:
    """Lowest and highest point of the bodies of one sweep, `spare` beyond."""
    z = np.concatenate([corners[:, 2] for corners, _ in swept])
    return float(z.min()) - spare, float(z.max()) + spare


def _layer_faces(spans: Sequence[tuple[float, float]], spare: float) -> list[float]:
    """Heights between layers: evenly spaced, and at the lowest and highest point of each sweep."""
    low, high = min(a for a, _ in spans), max(b for _, b in spans)
    heights = sorted({z for span in spans for z in span} | set(np.linspace(low, high, HEIGHT_LAYERS + 1).tolist()))
    faces = [heights[0]]
    for z in heights[1:]:
        if z - faces[-1] > 2.0 * spare:
            faces.append(z)
    faces[-1] = high
    return faces


def _outline(hulls: Sequence[tuple[FloatArray, IntArray]], low: float, high: float, spare: float) -> BaseGeometry:
    """The region (x, y) over which the bodies lie between two heights, with `spare` to all sides."""
    pieces: list[BaseGeometry] = []
    for corners, edges in hulls:
        z = corners[:, 2]
        if z.max() < low - spare or z.min() > high + spare:
            continue
        within = corners[(z >= low - spare) & (z <= high + spare), :2]
        starts, ends = corners[edges[:, 0]], corners[edges[:, 1]]
        crossings = [within]
        for face in (low - spare, high + spare):
            crosses = (starts[:, 2] - face) * (ends[:, 2] - face) < 0.0
            share = (face - starts[crosses, 2]) / (ends[crosses, 2] - starts[crosses, 2])
            crossings.append(starts[crosses, :2] + share[:, None] * (ends[crosses, :2] - starts[crosses, :2]))
        pieces.append(shapely.MultiPoint(np.concatenate(crossings)).convex_hull)
    if not pieces:
        return shapely.Polygon()
    union = shapely.union_all(pieces).buffer(spare, join_style="mitre")
    rough = union.buffer(spare, join_style="mitre").simplify(spare)
    return rough if rough.covers(union) else union


def _alike(one: BaseGeometry, other: BaseGeometry) -> bool:
    return shapely.symmetric_difference(one, other).area <= MERGE_SHARE * one.area
