"""Tessellation of the implicit shapes of UsdGeom: cube, plane, and bodies of revolution.

Shapes follow the OpenUSD schema (UsdGeom: Cube, Plane, Sphere, Cylinder, Cone, Capsule): centred on the origin, the
axis along +z. Curved shapes are inscribed; rings start on +x and have a multiple of four corners, so the bounding box
of the round shape is met exactly.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from schemas.arrays import FloatArray, IntArray

SEGMENTS: Final = 48


class Tessellation(NamedTuple):
    """points (n, 3) float64; triangles (m, 3) int64, counter-clockwise from outside; unit normals (m, 3, 3)."""

    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray


def cube(size: float) -> Tessellation:
    """A closed cube of edge length `size`."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    outward = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]], dtype=np.float64)
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    normals = np.broadcast_to(np.repeat(outward, 2, axis=0)[:, None], (12, 3, 3)).copy()
    return Tessellation(corners * (size / 2.0), triangles, normals)


def plane(width: float, length: float) -> Tessellation:
    """An open rectangle, `width` along x and `length` along y, facing +z."""
    half = np.array([width / 2.0, length / 2.0, 0.0])
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float64) * half
    normals = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (2, 3, 3)).copy()
    return Tessellation(points, np.array([[0, 1, 2], [0, 2, 3]]), normals)


def sphere(radius: float, segments: int = SEGMENTS) -> Tessellation:
    """A closed sphere of `segments` meridians and half as many stacks."""
    directions = _arc(-np.pi / 2, np.pi / 2, segments // 2)
    return _revolve(radius * directions, np.stack([directions[:-1], directions[1:]], axis=1), segments)


def cylinder(height: float, radius_bottom: float, radius_top: float, segments: int = SEGMENTS) -> Tessellation:
    """A closed cylinder or truncated cone; a zero radius makes the cone whose apex is at that end."""
    z = height / 2.0
    slope = np.array([height, radius_bottom - radius_top], dtype=np.float64)
    side = slope / max(float(np.linalg.norm(slope)), np.finfo(float).tiny)
    profile = [(0.0, -z)]
    normals: list[FloatArray] = []
    if radius_bottom > 0:
        profile.append((radius_bottom, -z))
        normals.append(np.array([[0.0, -1.0], [0.0, -1.0]]))
    normals.append(np.array([side, side]))
    if radius_top > 0:
        profile.append((radius_top, z))
        normals.append(np.array([[0.0, 1.0], [0.0, 1.0]]))
    return _revolve(np.array([*profile, (0.0, z)]), np.array(normals), segments)


def capsule(height: float, radius_bottom: float, radius_top: float, segments: int = SEGMENTS) -> Tessellation:
    """A closed capsule; `height` is that of the part between the two half spheres."""
    lower, upper = _arc(-np.pi / 2, 0.0, segments // 4), _arc(0.0, np.pi / 2, segments // 4)
    shift = np.array([0.0, height / 2.0])
    profile = np.concatenate([radius_bottom * lower - shift, radius_top * upper + shift])
    directions = np.concatenate([lower, upper])
    return _revolve(profile, np.stack([directions[:-1], directions[1:]], axis=1), segments)


def _arc(start_rad: float, stop_rad: float, steps: int) -> np.ndarray:
    """(steps + 1, 2) points (radius, z) of a unit circle; the poles lie exactly on the axis."""
    angles = np.linspace(start_rad, stop_rad, steps + 1)
    arc = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    arc[np.abs(arc) < 1e-15] = 0.0
    return arc


def _revolve(profile: np.ndarray, normals: np.ndarray, segments: int) -> Tessellation:
    """The closed surface swept by a profile turned about z.

    profile (k, 2) of (radius, z) from the bottom pole to the top pole, both on the axis;
    normals (k - 1, 2, 2) of (radial, z) at both ends of each piece of the profile.
    """
    angles = np.arange(segments) * (2.0 * np.pi / segments)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    unit[np.abs(unit) < 1e-15] = 0.0
    rings = profile[1:-1]
    sides = np.concatenate([rings[:, None, None, 0] * unit, np.full((len(rings), segments, 1), 0.0)], axis=2)
    sides[..., 2] = rings[:, 1, None]
    poles = np.array([[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]])
    points = np.concatenate([poles, sides.reshape(-1, 3)])

    here, there = np.arange(segments), (np.arange(segments) + 1) % segments
    triangles: list[IntArray] = []
    corner_normals: list[FloatArray] = []
    last = len(profile) - 2
    for piece, ends in enumerate(normals):
        low = 2 + (piece - 1) * segments
        high = low + segments
        around = np.stack([np.concatenate([unit * e[0], np.full((segments, 1), e[1])], axis=1) for e in ends])
        lower, upper = around
        if piece < last:
            a = np.zeros(segments, np.int64) if piece == 0 else low + here
            triangles.append(np.stack([a, high + there, high + here], axis=1))
            corner_normals.append(np.stack([lower[here], upper[there], upper[here]], axis=1))
        if piece > 0:
            b = np.ones(segments, np.int64) if piece == last else high + there
            triangles.append(np.stack([low + here, low + there, b], axis=1))
            corner_normals.append(np.stack([lower[here], lower[there], upper[there]], axis=1))
    return Tessellation(points, np.concatenate(triangles), np.concatenate(corner_normals))
