"""Vertices of a referenced mesh in the frame of its shape."""

from __future__ import annotations

import numpy as np

from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.robot_description import MeshReference


def in_shape_frame(mesh: MeshReference, vertices: FloatArray) -> FloatArray:
    """Vertices (n, 3) of the file at scale * R^T (v - p), R and p the reference frame of the mesh (MuJoCo)."""
    if any(mesh.reference_position_m):
        vertices = vertices - np.array(mesh.reference_position_m)
    if any(mesh.reference_quat_wxyz[1:]):
        vertices = vertices @ matrix_of(np.array(mesh.reference_quat_wxyz))
    return vertices * np.array(mesh.scale)
