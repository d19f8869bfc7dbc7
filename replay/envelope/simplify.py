"""Error-bounded simplification of many polylines at once (Douglas and Peucker 1973)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class PolylineSpans:
    """Segments that replace stretches of polylines; all arrays (s,).

    line, first, last  polyline, its first and its last knot.
    deviation_m        largest distance of a knot between them from the segment. Since distance to a segment is convex,
                       no point of the stretch is farther.
    """

    line: IntArray
    first: IntArray
    last: IntArray
    deviation_m: FloatArray


def simplify(points: FloatArray, tolerance_m: float) -> PolylineSpans:
    """Spans of polylines `points` (lines, knots, 3), none of which deviates by more than `tolerance_m`.

    All stretches of one depth of the recursion are split together. A polyline of one knot becomes a span of no length.
    """
    lines, knots = points.shape[:2]
    line, first = np.arange(lines), np.zeros(lines, dtype=np.int64)
    last = np.full(lines, knots - 1)
    done: list[tuple[IntArray, IntArray, IntArray, FloatArray]] = []
    while len(line):
        deviation, worst = _farthest(points, line, first, last)
        split = deviation > tolerance_m
        kept = ~split
        done.append((line[kept], first[kept], last[kept], deviation[kept]))
        line, first, worst, last = line[split], first[split], worst[split], last[split]
        line, first, last = np.tile(line, 2), np.concatenate([first, worst]), np.concatenate([worst, last])
    line, first, last, deviation = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((first, line))
    return PolylineSpans(line[order], first[order], last[order], deviation[order])


def _farthest(points: FloatArray, line: IntArray, first: IntArray, last: IntArray) -> tuple[FloatArray, IntArray]:
    """Largest distance (s,) of a knot inside each stretch from its chord, and which knot it is."""
    inner = last - first - 1
    deviation, worst = np.zeros(len(line)), first.copy()
    some = np.flatnonzero(inner > 0)
    if not len(some):
        return deviation, worst
    counts = inner[some]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    stretch = np.repeat(np.arange(len(some)), counts)
    knot = np.arange(len(stretch)) - starts[stretch] + first[some][stretch] + 1
    begin = points[line[some], first[some]]
    along = points[line[some], last[some]] - begin
    away = points[line[some][stretch], knot] - begin[stretch]
    square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    share = np.clip(np.einsum("ij,ij->i", away, along[stretch]) / square[stretch], 0.0, 1.0)
    away -= share[:, None] * along[stretch]
    squared = np.einsum("ij,ij->i", away, away)
    largest = np.maximum.reduceat(squared, starts)
    hits = np.flatnonzero(squared == largest[stretch])
    _, leading = np.unique(stretch[hits], return_index=True)
    deviation[some], worst[some] = np.sqrt(largest), knot[hits[leading]]
    return deviation, worst
