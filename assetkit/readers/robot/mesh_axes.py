"""Axes of glTF files named by a description: taken as they are, unless the collision shapes show that y is up there.

glTF has y up; URDF says nothing on it, and importers differ. The collision shapes of the same link decide.
"""

from __future__ import annotations

import numpy as np

from assetkit.pose.up_axis import TO_Z_UP
from assetkit.readers.robot.shapes import SurfaceReader
from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedLink, DescribedShape

_Y_UP_FILES = (".glb", ".gltf")
_BETTER_FIT = 0.5  # of the misfit of the file's own axes


def mesh_turn(shape: DescribedShape, link: DescribedLink, surfaces: SurfaceReader) -> FloatArray:
    """R (3, 3) to turn the mesh of a shape by, in its own frame, before anything else; the identity in most cases."""
    if shape.mesh is None or not shape.mesh.path.lower().endswith(_Y_UP_FILES):
        return np.eye(3)
    boxes = [_corners(other) for other in link.shapes if other.collides and other.kind == "box" and not other.problem]
    if not boxes:
        return np.eye(3)
    target = _bounds(np.concatenate(boxes))
    points = np.concatenate([mesh.points for mesh in surfaces.meshes_of(shape.mesh)]) * np.array(shape.mesh.scale)
    turns = (np.eye(3), TO_Z_UP["y"])
    misfit = [float(np.abs(_bounds(apply(shape.X_LS, points @ R.T)) - target).max()) for R in turns]
    return turns[1] if misfit[1] < _BETTER_FIT * misfit[0] else turns[0]


def _corners(shape: DescribedShape) -> FloatArray:
    half = np.array(shape.size_m) / 2.0
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    return apply(shape.X_LS, signs * half)


def _bounds(points: FloatArray) -> FloatArray:
    return np.stack([points.min(axis=0), points.max(axis=0)])
