"""Candidate cutting planes of a closed surface of unit size: across axes, along faces and bisectors of reflex edges."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray, IntArray

STEPS = 3  # planes across each axis, at even steps
FACE_PLANES, BISECTORS = 16, 8
# Large surfaces cost more per plane and get fewer.
MANY_FACES, FEW_PLANES = 5000, (6, 0)
# Edges are reflex from this angle on (radians); flatter ones are tessellation.
LEAST_ANGLE = 0.15
# Planes this close (unit size) count as one.
FACE_GRID, BISECTOR_GRID = 0.01, 0.1
# A cut along a face leaves no film of the other part on it.
FILM = 1e-5
ALIGNED = 0.99


def candidate_planes(
    points: FloatArray, triangles: IntArray, edges: IntArray, sides: IntArray, hull_points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Unit normals (k, 3) and offsets (k,) for a closed surface of unit size.

    `edges` (e, 2) holds each edge once, `sides` (e, 2) its two faces. Coordinate axes come first, then the
    principal axes of the hull's points, then the planes that most reflex edge length (times its angle) lies on.
    """
    planes = [_across(points, hull_points)]
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(lengths, np.finfo(float).tiny)[:, None]
    offsets = np.einsum("ij,ij->i", normals, a)
    first, second = sides.T
    opposite = triangles[second].sum(axis=1) - edges.sum(axis=1)
    rise = np.einsum("ij,ij->i", normals[first], points[opposite]) - offsets[first]
    cosine = np.einsum("ij,ij->i", normals[first], normals[second])
    sound = lengths > 1e-12
    reflex = np.flatnonzero((rise > 1e-6) & (cosine < np.cos(LEAST_ANGLE)) & sound[first] & sound[second])
    face_planes, bisectors = (FACE_PLANES, BISECTORS) if len(triangles) <= MANY_FACES else FEW_PLANES
    if len(reflex):
        ends = points[edges[reflex]]
        weight = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) * np.arccos(np.clip(cosine[reflex], -1.0, 1.0))
        faces = np.concatenate([first[reflex], second[reflex]])
        top = faces[_heaviest(normals[faces], offsets[faces], np.tile(weight, 2), FACE_GRID, face_planes)]
        planes.append((normals[top], offsets[top] + FILM))
        between = normals[first[reflex]] - normals[second[reflex]]
        between /= np.maximum(np.linalg.norm(between, axis=1), np.finfo(float).tiny)[:, None]
        through = np.einsum("ij,ij->i", between, ends[:, 0])
        top = _heaviest(between, through, weight, BISECTOR_GRID, bisectors)
        planes.append((between[top], through[top]))
    return np.concatenate([n for n, _ in planes]), np.concatenate([d for _, d in planes])


def _across(points: FloatArray, hull_points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """`STEPS` planes across each coordinate axis and each principal axis of the hull that is not one."""
    centred = hull_points - hull_points.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1].T
    axes = np.concatenate([np.eye(3), principal[np.abs(principal).max(axis=1) < ALIGNED]])
    along = points @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    share = (np.arange(STEPS) + 1.0) / (STEPS + 1.0)
    offsets = low[:, None] + share * (high - low)[:, None]
    return np.repeat(axes, STEPS, axis=0), offsets.reshape(-1)


def _heaviest(normals: FloatArray, offsets: FloatArray, weights: FloatArray, grid: float, most: int) -> IntArray:
    """Indices of one plane from each of the `most` heaviest groups of near-equal planes, heaviest first."""
    cells = np.round(np.column_stack([normals, offsets]) / grid).astype(np.int64)
    _, first, group = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return first[np.argsort(-np.bincount(group.reshape(-1), weights), kind="stable")[:most]]
