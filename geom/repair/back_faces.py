"""Removal of back faces: copies of faces in reverse winding, added for renderers that cull back sides."""

from __future__ import annotations

import numpy as np

from geom.mesh.components import components_of
from geom.mesh.duplicate_shells import DOUBLE_SIDED_SHARE, later_copies
from geom.mesh.edit import keep_faces
from schemas.arrays import BoolArray, IntArray
from schemas.model import Mesh


def drop_back_faces(mesh: Mesh) -> Mesh:
    """`mesh` (welded, no repeated points) with one side of each double-sided component, the first in file order.

    Single reversed copies elsewhere stay: two solids in contact share such a pair.
    """
    parts = components_of(mesh.points, mesh.triangles)
    back = reversed_copies(mesh.triangles)
    share = np.bincount(parts.label[back], minlength=parts.count) / np.maximum(parts.faces, 1)
    return keep_faces(mesh, ~(back & (share >= 0.5 * DOUBLE_SIDED_SHARE)[parts.label]))


def reversed_copies(triangles: IntArray) -> BoolArray:
    """(m,) True where an earlier face has the same points; copies with the same winding are gone beforehand."""
    return later_copies(np.sort(triangles, axis=1))
