"""Shape change of an edit: two-way Hausdorff distance between the surface before and after, and the changed faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.mesh.hausdorff import ZERO_DISTANCE, DistanceBounds, one_sided_hausdorff
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import diagonal
from schemas.arrays import BoolArray, FloatArray, IntArray

Surface = tuple[FloatArray, IntArray]
# The search for the largest distance ends within this share of the diagonal.
EDIT_TOLERANCE_SHARE = 1e-4


@dataclass(frozen=True)
class ShapeChange:
    """Two-way distance between a surface before and after an edit, in the unit of the points.

    removed  distance of the removed faces from the surface after the edit.
    added    distance of the new faces from the surface before it.
    diagonal of the surface before.
    """

    removed: DistanceBounds
    added: DistanceBounds
    diagonal: float

    @property
    def hausdorff(self) -> float:
        """The two-way Hausdorff distance, attained by a point of either surface."""
        return max(self.removed.attained, self.added.attained)

    @property
    def bound(self) -> float:
        """A proven upper bound of the Hausdorff distance."""
        return max(self.removed.bound, self.added.bound)

    @property
    def share(self) -> float:
        """`hausdorff` as a share of the diagonal."""
        return self.hausdorff / self.diagonal if self.diagonal > 0.0 else 0.0


def shape_change(before: Surface, after: Surface) -> ShapeChange:
    """The distance both ways; faces with the same three corners on both sides have distance 0.

    Infinite when one of the surfaces is empty.
    """
    removed, added = changed_faces(before, after)
    size = diagonal(before[0][np.unique(before[1])])
    return ShapeChange(_reach(removed, before, after, size), _reach(added, after, before, size), size)


def changed_faces(before: Surface, after: Surface) -> tuple[BoolArray, BoolArray]:
    """(m,) True for faces of `before` that `after` lacks, and the other way round; winding does not matter."""
    faces_before, faces_after = _face_numbers(*before), _face_numbers(*after)
    return ~np.isin(faces_before, faces_after), ~np.isin(faces_after, faces_before)


def _face_numbers(points: FloatArray, triangles: IntArray) -> IntArray:
    """(m,) a 64-bit number per face, equal for equal corners in any order.

    Sorting whole coordinates of a million faces would cost more than every repair. Mixing: the finaliser of splitmix64
    (Steele, Lea and Flood 2014); two of a million faces share a number by chance once in ten million meshes.
    """
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64)  # -0.0 becomes 0.0
    number = _mixed(_mixed(_mixed(bits[:, 0]) + bits[:, 1]) + bits[:, 2])
    return number[triangles].sum(axis=1)


def _mixed(bits: IntArray) -> IntArray:
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return bits ^ (bits >> np.uint64(31))


def _reach(moved: BoolArray, mine: Surface, theirs: Surface, size: float) -> DistanceBounds:
    if not moved.any():
        return ZERO_DISTANCE
    if not triangle_areas(theirs[0][theirs[1]]).any():
        return DistanceBounds(np.inf, np.inf, mine[0][mine[1][moved][0, 0]])
    return one_sided_hausdorff(mine[0][mine[1][moved]], *theirs, EDIT_TOLERANCE_SHARE * size)
