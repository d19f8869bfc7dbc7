"""Pixels of an object that a camera sees, by rays through the middles of pixels against convex prisms (metres, W).

A prism is the intersection of half-spaces: its edges and its two ends. A ray enters it where it has entered all of
these, and leaves it where it leaves the first. A pixel shows the object that its ray enters first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.scene.camera_pose import CameraPose
from schemas.scene.geometry import Prism

NEAR_M = 1e-3  # nearer than this a camera sees nothing


def visible_pixels(camera: CameraPose, target: Sequence[Prism], others: Sequence[Prism]) -> int:
    """Number of pixels in which the camera sees `target` before any of the others."""
    rays = _rays(camera, target)
    if len(rays) == 0:
        return 0
    origin = np.asarray(camera.position_m)
    first = _entries(origin, rays, target)
    rays, first = rays[np.isfinite(first)], first[np.isfinite(first)]
    return int((first < _entries(origin, rays, others)).sum())


def _rays(camera: CameraPose, target: Sequence[Prism]) -> FloatArray:
    """(m, 3) rays in W through the pixels of the rectangle around the target, of unit length along the view."""
    width, height = camera.size
    R_WC = matrix_of(np.asarray(camera.quat_wxyz))
    half = np.tan(np.radians(camera.fov_deg) / 2.0)
    corners = np.concatenate([
        np.column_stack([prism.outline_m, np.full(len(prism.outline_m), z)])
        for prism in target for z in (prism.low_m, prism.high_m)
    ])  # fmt: skip
    at = (corners - np.asarray(camera.position_m)) @ R_WC
    columns, rows = (0, width), (0, height)
    if (at[:, 2] < -NEAR_M).all():
        x = (at[:, 0] / -at[:, 2] / (half * width / height) + 1.0) * 0.5 * width
        y = (1.0 - at[:, 1] / -at[:, 2] / half) * 0.5 * height
        columns = max(int(np.floor(x.min())), 0), min(int(np.ceil(x.max())), width)
        rows = max(int(np.floor(y.min())), 0), min(int(np.ceil(y.max())), height)
    i, j = np.meshgrid(np.arange(*columns) + 0.5, np.arange(*rows) + 0.5)
    across = (2.0 * i / width - 1.0) * half * width / height
    up = (1.0 - 2.0 * j / height) * half
    return np.stack([across, up, np.full_like(across, -1.0)], axis=-1).reshape(-1, 3) @ R_WC.T


def _entries(origin: FloatArray, rays: FloatArray, prisms: Sequence[Prism]) -> FloatArray:
    """(m,) distance along each ray at which it enters the first of some prisms; inf where it meets none."""
    nearest = np.full(len(rays), np.inf)
    for prism in prisms:
        edges = np.roll(prism.outline_m, -1, axis=0) - prism.outline_m
        normals = np.column_stack([edges[:, 1], -edges[:, 0], np.zeros(len(edges))])
        normals = np.vstack([normals, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        offsets = np.concatenate([
            (normals[:-2, :2] * prism.outline_m).sum(axis=1), [prism.high_m, -prism.low_m]
        ])  # fmt: skip
        slope, left = rays @ normals.T, offsets - normals @ origin
        with np.errstate(divide="ignore", invalid="ignore"):
            at = left / slope
        enter = np.where(slope < 0.0, at, -np.inf).max(axis=1)
        leave = np.where(slope > 0.0, at, np.inf).min(axis=1)
        beside = ((slope == 0.0) & (left < 0.0)).any(axis=1)
        enter = np.maximum(enter, NEAR_M)
        nearest = np.where(~beside & (enter < leave), np.minimum(nearest, enter), nearest)
    return nearest
