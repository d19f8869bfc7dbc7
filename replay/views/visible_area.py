"""The part of a level plane (m, W) that recorded cameras have in their pictures."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from replay.recording.episode import Camera
from schemas.arrays import FloatArray

ROWS = 12  # of a recording, evenly spread, at which views are tested
_NEAR_M = 0.01


def area_in_view(cameras: tuple[Camera, ...], height_m: float, within: BaseGeometry) -> BaseGeometry:
    """The part of the plane at `height_m` over `within` that some camera has in its picture at some of its stamps."""
    parts = [_seen(camera, X, height_m, within) for camera in cameras for X in _poses(camera)]
    return shapely.union_all([part for part in parts if not part.is_empty])


def in_picture(camera: Camera, points_W: FloatArray) -> bool:
    """Whether the camera has one of the points (n, 3) in its picture at some of its stamps."""
    normals = _sides(camera)
    for X_WC in _poses(camera):
        points_C = (points_W - X_WC[:3, 3]) @ X_WC[:3, :3]
        if bool(((points_C @ normals.T >= 0.0).all(axis=1) & (points_C[:, 2] < -_NEAR_M)).any()):
            return True
    return False


def _poses(camera: Camera) -> FloatArray:
    moving = bool(np.ptp(camera.X_WC, axis=0).any())
    rows = np.unique(np.linspace(0, len(camera.X_WC) - 1, ROWS).astype(int)) if moving else [0]
    return camera.X_WC[rows]


def _sides(camera: Camera) -> FloatArray:
    """Inward normals (4, 3) in C of the planes through the eye and the edges of the picture."""
    up = np.tan(0.5 * camera.fovy_rad)
    right = up * camera.width_px / camera.height_px
    normals = np.array([[1.0, 0.0, -right], [-1.0, 0.0, -right], [0.0, 1.0, -up], [0.0, -1.0, -up]])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _seen(camera: Camera, X_WC: FloatArray, height_m: float, within: BaseGeometry) -> BaseGeometry:
    """Half planes of `height_m` behind the sides of the picture, cut from the box around `within`."""
    planes_C = [*((normal, 0.0) for normal in _sides(camera)), (np.array([0.0, 0.0, -1.0]), _NEAR_M)]
    area: BaseGeometry = shapely.envelope(within)
    for normal_C, least in planes_C:
        normal_W = X_WC[:3, :3] @ normal_C
        offset = least + normal_W @ X_WC[:3, 3] - normal_W[2] * height_m
        area = area.intersection(_half_plane(normal_W[:2], offset, area))
    return area


def _half_plane(normal: FloatArray, offset: float, around: BaseGeometry) -> BaseGeometry:
    """Points x near `around` with normal @ x >= offset."""
    length = float(np.linalg.norm(normal))
    if around.is_empty or length < 1e-12:
        return around if offset <= 0.0 else Polygon()
    low_x, low_y, high_x, high_y = around.bounds
    centre, size = (
        np.array([low_x + high_x, low_y + high_y]) / 2.0,
        2.0 * np.hypot(high_x - low_x, high_y - low_y) + 1.0,
    )
    inward = normal / length
    along = np.array([-inward[1], inward[0]]) * size
    start = centre + (offset / length - inward @ centre) * inward
    return Polygon(
        [start - along, start + along, start + along + 2.0 * size * inward, start - along + 2.0 * size * inward]
    )
