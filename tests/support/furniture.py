"""Furniture and vessels of known measures as closed solids, in metres, standing on z = 0."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, OpType
from scipy.spatial.transform import Rotation

from geom.mesh.manifold_arrays import manifold_arrays
from schemas.physics import Solid


def block(x: float, y: float, z: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Manifold:
    """A box with its lower middle at `at`."""
    return Manifold.cube((x, y, z)).translate((at[0] - x / 2, at[1] - y / 2, at[2]))


def table(x: float = 1.2, y: float = 0.8, z: float = 0.75, top: float = 0.04) -> Manifold:
    legs = [block(0.06, 0.06, z, (i * (x / 2 - 0.05), j * (y / 2 - 0.05), 0)) for i in (-1, 1) for j in (-1, 1)]
    return Manifold.batch_boolean([block(x, y, top, (0, 0, z - top)), *legs], OpType.Add)


def shelf(heights: tuple[float, ...] = (0.02, 0.42, 0.92), *, top: float = 1.2) -> Manifold:
    """Boards 2 cm thick whose tops lie at `heights` and `top`, 0.8 x 0.3, between side and back walls; front at -y."""
    boards = [block(0.8, 0.3, 0.02, (0, 0, height - 0.02)) for height in (*heights, top)]
    walls = [block(0.02, 0.3, top, (0.39 * i, 0, 0)) for i in (-1, 1)] + [block(0.8, 0.02, top, (0, 0.14, 0))]
    return Manifold.batch_boolean([*boards, *walls], OpType.Add)


def open_box(x: float, y: float, z: float, wall: float) -> Manifold:
    """Outside measures; inside it is (x - 2 wall) (y - 2 wall) (z - wall)."""
    return block(x, y, z) - block(x - 2 * wall, y - 2 * wall, z, (0, 0, wall))


def solid_of(body: Manifold, yaw_rad: float = 0.0, scale: float = 1.0) -> Solid:
    points, triangles = manifold_arrays(body)
    R = Rotation.from_euler("z", yaw_rad).as_matrix()
    return Solid(scale * np.asarray(points, dtype=np.float64) @ R.T, triangles.astype(np.int32), "closed")
