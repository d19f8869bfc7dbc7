"""A bar or knob that stands out of the outer face of a leaf or drawer front: what a hand takes hold of.

From the surface of the moved link and the direction out of its face, into the points of the grip. Metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from geom.mesh.surface_distance import sample_surface
from schemas.arrays import BoolArray, FloatArray
from schemas.physics import Solid

GRIP_SAMPLES = 8000
FACING = 0.9  # cosine to the outward direction of the samples of a face
# Of the diagonal of the link: the face is even within it, and a grip stands out by more.
STANDS_OUT = 0.012
# A raised frame or panel spans the face both ways; a bar may span it one way only.
MOST_SHORT_SIDE = 0.4
GAP = 0.04  # of the diagonal: samples nearer than this are of one piece
LEAST_SAMPLES = 8
FROM_AXIS = 0.4  # of the radius: a grip is away from the hinge
KNOB_RATIO, KNOB_SHARE = 2.0, 0.35  # sides of a knob; its longer side of the shorter one of the face
_LEVELS = 4  # raised frames and mouldings below a grip, at most


@dataclass(frozen=True)
class StandingGrip:
    """Points (n, 3) of a grip on a face; `is_knob` as against a bar."""

    points: FloatArray
    is_knob: bool


def find_standing_grip(
    solid: Solid, outward: FloatArray, line: tuple[FloatArray, FloatArray] | None = None
) -> StandingGrip | None:
    """The largest grip on the face of a link towards `outward` (3,) (unit); None where nothing stands out.

    `line` is the axis of a hinge, a point and a unit direction (3,): a grip is away from it.
    """
    points, faces = sample_surface(solid.points, solid.triangles, GRIP_SAMPLES, seed=0)
    corners = solid.points[solid.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    facing = np.abs(normals[faces] @ outward) >= FACING if solid.kind == "shell" else normals[faces] @ outward >= FACING
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    height, step = points @ outward, STANDS_OUT * size
    flat = _in_plane(points, outward, line)
    face_sides = np.ptp(flat, axis=0)
    if not facing.any():
        return None
    level = _main_level(height[facing], step)
    for _ in range(_LEVELS):
        out = height > level + step
        if int(out.sum()) < LEAST_SAMPLES:
            return None
        grip = _best_piece(points, flat, out, size, face_sides, line)
        if grip is not None:
            return grip
        if not (out & facing).any():
            return None
        level = _main_level(height[out & facing], step)
    return None


def _main_level(heights: FloatArray, step: float) -> float:
    """The height around which, within a step to both sides, most samples (n,) lie."""
    ordered = np.sort(heights)
    held = np.searchsorted(ordered, ordered + step, side="right") - np.searchsorted(ordered, ordered - step)
    return float(ordered[int(held.argmax())])


def _best_piece(
    points: FloatArray,
    flat: FloatArray,
    out: BoolArray,
    size: float,
    face_sides: FloatArray,
    line: tuple[FloatArray, FloatArray] | None,
) -> StandingGrip | None:
    """The largest connected piece of the samples that stand out which has the form and the place of a grip."""
    standing = points[out]
    pairs = KDTree(standing).query_pairs(GAP * size, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(standing), len(standing)))
    count, label = connected_components(graph, directed=False)
    best: StandingGrip | None = None
    for k in range(count):
        piece = standing[label == k]
        if len(piece) < LEAST_SAMPLES or (best is not None and len(piece) <= len(best.points)):
            continue
        sides = np.sort(np.ptp(flat[out][label == k], axis=0))
        if sides[0] > MOST_SHORT_SIDE * float(face_sides.min()) or not _away(piece, points, line):
            continue
        is_knob = sides[1] <= KNOB_RATIO * sides[0] and sides[1] <= KNOB_SHARE * float(face_sides.min())
        best = StandingGrip(piece, is_knob)
    return best


def _away(piece: FloatArray, points: FloatArray, line: tuple[FloatArray, FloatArray] | None) -> bool:
    """Whether a piece lies away from the hinge."""
    if line is None:
        return True
    return float(_distance(piece, line).mean()) >= FROM_AXIS * float(_distance(points, line).max())


def _distance(points: FloatArray, line: tuple[FloatArray, FloatArray]) -> FloatArray:
    local = points - line[0]
    return np.linalg.norm(local - (local @ line[1])[:, None] * line[1], axis=1)


def _in_plane(points: FloatArray, outward: FloatArray, line: tuple[FloatArray, FloatArray] | None) -> FloatArray:
    """Coordinates (n, 2) in the face: along the hinge, or level where there is none, and across."""
    along = line[1] if line is not None else np.array([0.0, 0.0, 1.0])
    first = np.cross(outward, along)
    if np.linalg.norm(first) < 0.1:
        first = np.cross(outward, np.eye(3)[int(np.argmin(np.abs(outward)))])
    first = np.asarray(first / np.linalg.norm(first), dtype=np.float64)
    return np.stack([points @ first, points @ np.cross(outward, first)], axis=1)
