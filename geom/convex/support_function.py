"""Support function of convex collision shapes and measures from it, in metres in the asset frame.

Ericson, *Real-Time Collision Detection* (2005), section 9.5.4: the support function of a union is the largest of the
supports of its members, so heights over a plane are exact without meshing curved shapes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geom.mesh import primitives
from geom.pose import apply, shortest_rotation
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape

_AZIMUTHS = 720  # A long rod rolls in one direction only: the nearest of these is within a quarter of a degree.
_TIP_RAD = np.radians(1.0)
_BLOCK = 2**17  # products of directions and corners at a time: 1 MB, which stays in the cache of a core


def support(shapes: Sequence[CollisionShape], directions_A: FloatArray) -> FloatArray:
    """The largest `x . d` (k,) in metres over the points x of all shapes, for unit directions d (k, 3)."""
    largest = np.full(len(directions_A), -np.inf)
    placed, others = _placed_corners(shapes)
    if placed:
        corners = np.concatenate(placed)
        for first in range(0, len(directions_A), max(1, _BLOCK // len(corners))):
            rows = slice(first, first + max(1, _BLOCK // len(corners)))
            np.max(directions_A[rows] @ corners.T, axis=1, out=largest[rows])
    for shape in others:
        local = directions_A @ shape.X_AS[:3, :3]
        np.maximum(largest, _local_support(shape, local) + directions_A @ shape.X_AS[:3, 3], out=largest)
    return largest


def _placed_corners(shapes: Sequence[CollisionShape]) -> tuple[list[FloatArray], list[CollisionShape]]:
    """The corners of all hulls that are given in the asset frame itself, and the other shapes."""
    at_home = (np.stack([shape.X_AS for shape in shapes]) == np.eye(4)).all(axis=(1, 2)) if shapes else ()
    placed: list[FloatArray] = []
    others: list[CollisionShape] = []
    for shape, home in zip(shapes, at_home, strict=True):
        if home and shape.kind == "hull" and shape.points is not None:
            placed.append(shape.points)
        else:
            others.append(shape)
    return placed, others


def bounds(shapes: Sequence[CollisionShape]) -> FloatArray:
    """Lowest and highest corner (2, 3) of the box around all shapes, in metres."""
    axes = np.eye(3)
    return np.stack([-support(shapes, -axes), support(shapes, axes)])


def diagonal(shapes: Sequence[CollisionShape]) -> float:
    """Length in metres of the diagonal of the box around all shapes."""
    low, high = bounds(shapes)
    return float(np.linalg.norm(high - low))


def heights(shapes: Sequence[CollisionShape], positions_m: FloatArray, R_WA: FloatArray) -> FloatArray:
    """Height (k,) of the lowest point over the plane z = 0 for origins (k, 3) and orientations (k, 3, 3)."""
    return positions_m[:, 2] - support(shapes, -R_WA[:, 2, :])


def centre_heights(shapes: Sequence[CollisionShape], centre_m: FloatArray, down_A: FloatArray) -> FloatArray:
    """Height (k,) of the mass centre (3,) over the plane a body stands on, for body-frame down directions (k, 3).

    Up to the factor `m g` this is the potential energy of the body resting on that side; its local minima are the
    stable poses (Goldberg et al. 1999, "Part pose statistics", section 3).
    """
    return support(shapes, down_A) - down_A @ centre_m


def stability_margin(
    shapes: Sequence[CollisionShape], centre_m: FloatArray, down_A: FloatArray
) -> tuple[float, FloatArray]:
    """Distance (m) of the mass centre (3,) from the edge of the support of a body at rest with `down_A` (3,) down, and
    the     down direction (3,) after a tilt of one degree to that weakest side.

    Measured as the lever arm of the weight, `rise / sin 1 deg`: 0 for a body that rolls, negative for one that falls.
    """
    azimuths = np.arange(_AZIMUTHS) * (2.0 * np.pi / _AZIMUTHS)
    tipped = np.stack([np.cos(azimuths), np.sin(azimuths), np.full(_AZIMUTHS, -1.0 / np.tan(_TIP_RAD))], axis=1)
    tipped = np.sin(_TIP_RAD) * tipped @ shortest_rotation(np.array([0.0, 0.0, -1.0]), down_A).T
    rises = centre_heights(shapes, centre_m, tipped) - centre_heights(shapes, centre_m, down_A[None])
    weakest = int(rises.argmin())
    return float(rises[weakest] / np.sin(_TIP_RAD)), tipped[weakest]


def facet_directions(shapes: Sequence[CollisionShape]) -> FloatArray:
    """Outward unit normals (f, 3) of the convex hull of all shapes, each once; curved shapes count as tessellated.

    Empty (0, 3) when the shapes span no volume.
    """
    try:
        hull = ConvexHull(np.concatenate([surface(shape)[0] for shape in shapes]))
    except QhullError:
        return np.empty((0, 3))
    directions = np.unique(np.round(hull.equations[:, :3], 9), axis=0)
    return directions / np.linalg.norm(directions, axis=1)[:, None]


def surface(shape: CollisionShape) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) of one shape in the asset frame, curved shapes inscribed."""
    if shape.kind == "hull":
        points, triangles = shape.points, shape.triangles
        assert points is not None, "a hull has points"
        assert triangles is not None, "a hull has triangles"
    elif shape.kind == "box":
        points, triangles, _ = primitives.cube(1.0)
        points = points * np.asarray(shape.size_m)
    elif shape.kind == "sphere":
        points, triangles, _ = primitives.sphere(shape.size_m[0])
    elif shape.kind == "capsule":
        points, triangles, _ = primitives.capsule(shape.size_m[1], shape.size_m[0], shape.size_m[0])
    else:
        points, triangles, _ = primitives.cylinder(shape.size_m[1], shape.size_m[0], shape.size_m[0])
    return apply(shape.X_AS, points), triangles


def _local_support(shape: CollisionShape, local: FloatArray) -> FloatArray:
    """Support (k,) of one shape for directions (k, 3) in its own frame."""
    if shape.kind == "hull":
        assert shape.points is not None, "a hull has points"
        return (local @ shape.points.T).max(axis=1)
    if shape.kind == "box":
        return np.abs(local) @ np.asarray(shape.size_m) / 2.0
    radius = shape.size_m[0]
    if shape.kind == "sphere":
        return radius * np.linalg.norm(local, axis=1)
    half_height = np.abs(local[:, 2]) * shape.size_m[1] / 2.0
    if shape.kind == "capsule":
        return half_height + radius * np.linalg.norm(local, axis=1)
    return half_height + radius * np.linalg.norm(local[:, :2], axis=1)
