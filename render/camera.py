"""Cameras of four standard views and one hero view around a bounding box of largest edge 1.

The *annotation frame* N has its origin at the centre of the bounding box, axes of the asset frame, and the largest
edge of the box as unit of length: pictures of a 1 mm screw and a 400 m ship look alike.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.model import Mesh, Model

FIELD_OF_VIEW_RAD = float(np.radians(26.0))  # Long lens: little perspective, as in a product photograph.
FILL = 0.94  # Share of the picture that the box may cover; few objects reach the corners of their box.


@dataclass(frozen=True)
class CameraView:
    """A named direction to look from: azimuth counter-clockwise seen from above, 0 = in front (+x)."""

    name: str
    azimuth_deg: float
    elevation_deg: float


STANDARD_VIEWS = (
    CameraView("view_front", 0.0, 20.0),
    CameraView("view_left", 90.0, 20.0),
    CameraView("view_back", 180.0, 20.0),
    CameraView("view_top", -45.0, 60.0),  # From above the right front corner: the side the other three do not show.
)
HERO_VIEW = CameraView("thumbnail", 40.0, 25.0)


@dataclass(frozen=True)
class AnnotationFrame:
    """The normalised frame N: `p_N = (p_A - centre_m) / unit_m`; `extent` are the box edges in N, the largest is 1."""

    centre_m: FloatArray
    unit_m: float
    extent: FloatArray

    def from_asset(self, points_m: FloatArray) -> FloatArray:
        """(n, 3) points of the asset frame in the annotation frame, float64."""
        return (np.asarray(points_m, dtype=np.float64) - self.centre_m) / self.unit_m


def annotation_frame(low_m: FloatArray, high_m: FloatArray) -> AnnotationFrame:
    """The frame of the box `low_m`..`high_m`; a single point counts as a cube of 1 m."""
    size = np.asarray(high_m, dtype=np.float64) - low_m
    centre = np.asarray(low_m) + size / 2.0
    if size.max() <= 0.0:
        size = np.ones(3)
    return AnnotationFrame(centre, float(size.max()), size / size.max())


def model_frame(model: Model) -> AnnotationFrame:
    """The annotation frame of the finite points that triangles of `model` use; a unit box without any."""
    return frame_around(map(used_points, model.meshes))


def frame_around(clouds: Iterable[FloatArray]) -> AnnotationFrame:
    """The annotation frame of the box that holds all clouds (n, 3); a unit box without any point."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for points in clouds:
        if len(points):
            low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    if not np.isfinite(low).all():
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    return annotation_frame(low, high)


def used_points(mesh: Mesh) -> FloatArray:
    """(n, 3) the finite points that triangles of the mesh use."""
    used = mesh.points[np.unique(mesh.triangles)]
    return used[np.isfinite(used).all(axis=1)]


@dataclass(frozen=True)
class PinholeCamera:
    """A pinhole camera in the annotation frame that looks at its origin.

    `R_NC` holds the camera axes as columns: right, up, backward (toward the viewer).
    """

    R_NC: FloatArray
    distance: float
    near: float
    far: float

    @property
    def position(self) -> FloatArray:
        """(3,) the camera position in N."""
        return self.R_NC[:, 2] * self.distance

    def project(self, points_N: FloatArray, size_px: int) -> FloatArray:
        """(n, 2) pixel coordinates (x to the right, y down, origin at the top left corner) of (n, 3) points in N."""
        points_C = np.asarray(points_N) @ self.R_NC
        depth = self.distance - points_C[:, 2]
        plane = points_C[:, :2] / depth[:, None] / np.tan(FIELD_OF_VIEW_RAD / 2.0)
        return (np.array([1.0, -1.0]) * plane + 1.0) * size_px / 2.0


def camera(view: CameraView, extent: FloatArray) -> PinholeCamera:
    """The camera of `view` at the least distance from which a box of edges `extent` around the origin fits `FILL`.

    A corner at (x, y, z) in camera axes is inside while max(|x|, |y|) <= (distance - z) * FILL * tan(fov / 2).
    """
    azimuth, elevation = np.radians(view.azimuth_deg), np.radians(view.elevation_deg)
    backward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    R_NC = np.stack([right, np.cross(backward, right), backward], axis=1)
    signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
    corners_C = (signs * np.maximum(extent, 1e-3)) @ R_NC  # a box without size would put the camera into it
    slope = FILL * np.tan(FIELD_OF_VIEW_RAD / 2.0)
    distance = float((np.abs(corners_C[:, :2]).max(axis=1) / slope + corners_C[:, 2]).max())
    nearest = distance - float(corners_C[:, 2].max())
    return PinholeCamera(R_NC, distance, near=0.5 * nearest, far=distance + 4.0)
