"""The spout of a jug: where its rim extends in one direction beyond the ellipse that it otherwise follows (metres)."""

from __future__ import annotations

import numpy as np
import shapely

from schemas.arrays import FloatArray, IntArray

LIP_RAYS = 72
MIN_BULGE = 0.06  # least bulge of a spout, as a share of the mean radius
MIN_CONCAVITY = 0.001  # of the area: the flanks of a spout are concave, those of a triangle's corner are not
MAX_OTHER_BULGE = 0.5  # of the largest bulge, for every other one: a square has four corners


def find_spout(loop_m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Tip (3,), horizontal outward direction (3,) and the points (k, 3) of the spout of a level rim (n, 3), or None.

    The radius over the angle around the middle is compared with its mean and its first two harmonics; a spout
    leaves one narrow bulge, a rectangle four.
    """
    outline = shapely.Polygon(loop_m[:, :2])
    if outline.convex_hull.area < (1.0 + MIN_CONCAVITY) * outline.area:
        return None
    centre = np.array(outline.centroid.coords[0])
    angles = 2.0 * np.pi * np.arange(LIP_RAYS) / LIP_RAYS
    far = 2.0 * float(np.linalg.norm(loop_m[:, :2] - centre, axis=1).max())
    ends = centre + far * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cuts = [outline.intersection(shapely.LineString([centre, end])).length for end in ends]
    radius = np.array(cuts)
    basis = np.stack([np.ones(LIP_RAYS), *(f(k * angles) for k in (1, 2) for f in (np.cos, np.sin))], axis=1)
    # Fitted to the rest of the rim: the spout itself must not bend the ellipse.
    smooth = basis @ np.linalg.lstsq(basis, radius, rcond=None)[0]
    for _ in range(4):
        level = np.minimum(radius, smooth + 0.01 * radius.mean())
        smooth = basis @ np.linalg.lstsq(basis, level, rcond=None)[0]
    bulge = radius - smooth
    top = int(bulge.argmax())
    if bulge[top] < MIN_BULGE * radius.mean():
        return None
    within = np.abs((np.arange(LIP_RAYS) - top + LIP_RAYS // 2) % LIP_RAYS - LIP_RAYS // 2)
    raised = bulge > MAX_OTHER_BULGE * bulge[top]
    if raised[within > LIP_RAYS // 8].any():
        return None
    lip = np.flatnonzero(raised)
    lip = lip[np.argsort((lip - top + LIP_RAYS // 2) % LIP_RAYS, kind="stable")]
    outward = np.array([np.cos(angles[top]), np.sin(angles[top]), 0.0])
    height = float(loop_m[:, 2].mean())

    def at(index: IntArray) -> FloatArray:
        flat = centre + radius[index, None] * np.stack([np.cos(angles[index]), np.sin(angles[index])], axis=1)
        return np.column_stack([flat, np.full(len(index), height)])

    return at(np.array([top]))[0], outward, at(lip)
