"""What cameras see, by a z-buffer of triangles: independent of the rays by which cameras are drawn (metres, W).

The faces of all prisms are cut at a near plane, projected, and filled pixel by pixel; a pixel belongs to the object
whose face is nearest there. Pixels count where their middle lies in a face.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.scene.camera_pose import CameraPose
from schemas.scene.geometry import Prism

NEAREST_M = 1e-3  # of what a camera sees


def pixels_by_object(camera: CameraPose, objects: Mapping[str, Sequence[Prism]]) -> dict[str, int]:
    """Number of pixels in which each object is the nearest."""
    width, height = camera.size
    depth, nearest = np.full((height, width), np.inf), np.full((height, width), -1)
    R_WC, origin = matrix_of(np.asarray(camera.quat_wxyz)), np.asarray(camera.position_m)
    focal = 0.5 * height / np.tan(np.radians(camera.fov_deg) / 2.0)
    for number, prisms in enumerate(objects.values()):
        for prism in prisms:
            for face in _faces(prism):
                corners = _cut((face - origin) @ R_WC)
                for k in range(1, len(corners) - 1):
                    _fill(depth, nearest, number, corners[[0, k, k + 1]], focal)
    return {name: int((nearest == number).sum()) for number, name in enumerate(objects)}


def _faces(prism: Prism) -> Iterator[FloatArray]:
    """Corners (n, 3) of each face, in order around it."""
    low, high = (
        np.column_stack([prism.outline_m, np.full(len(prism.outline_m), z)]) for z in (prism.low_m, prism.high_m)
    )
    yield low
    yield high
    for k in range(len(low)):
        yield np.array([low[k - 1], low[k], high[k], high[k - 1]])


def _cut(corners: FloatArray) -> FloatArray:
    """The part (m, 3) of a convex face, in camera axes, beyond the near plane; the camera looks along -z."""
    ahead = -corners[:, 2] - NEAREST_M
    parts: list[FloatArray] = []
    for k in range(len(corners)):
        one, two, a, b = corners[k - 1], corners[k], ahead[k - 1], ahead[k]
        if (a < 0.0) != (b < 0.0):
            parts.append(one + (two - one) * a / (a - b))
        if b >= 0.0:
            parts.append(two)
    return np.array(parts).reshape(-1, 3)


def _fill(depth: FloatArray, nearest: FloatArray, number: int, corners: FloatArray, focal: float) -> None:
    """Enters a triangle in front of the camera: where it is nearer than what is there."""
    height, width = depth.shape
    x = 0.5 * width + focal * corners[:, 0] / -corners[:, 2]
    y = 0.5 * height - focal * corners[:, 1] / -corners[:, 2]
    area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    left, right = max(int(np.floor(x.min())), 0), min(int(np.ceil(x.max())), width)
    top, bottom = max(int(np.floor(y.min())), 0), min(int(np.ceil(y.max())), height)
    if area == 0.0 or left >= right or top >= bottom:
        return
    i, j = np.meshgrid(np.arange(left, right) + 0.5, np.arange(top, bottom) + 0.5)
    shares = [((x[b] - i) * (y[c] - j) - (x[c] - i) * (y[b] - j)) / area for b, c in ((1, 2), (2, 0), (0, 1))]
    inside = (shares[0] >= 0.0) & (shares[1] >= 0.0) & (shares[2] >= 0.0)
    inverse = sum(share / -z for share, z in zip(shares, corners[:, 2], strict=True))
    with np.errstate(divide="ignore"):
        there = 1.0 / inverse
    window = (slice(top, bottom), slice(left, right))
    nearer = inside & (there < depth[window])
    depth[window] = np.where(nearer, there, depth[window])
    nearest[window] = np.where(nearer, number, nearest[window])
