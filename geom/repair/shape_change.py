"""How far an edited surface lies from the surface it was made from, and which faces the edit touched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.mesh.hausdorff import NO_REACH, Reach, reach
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import diagonal
from schemas.model import FloatArray, IntArray

Surface = tuple[FloatArray, IntArray]
# The search for the largest distance ends within this share of the diagonal.
TOLERANCE_SHARE = 1e-4


@dataclass(frozen=True)
class ShapeChange:
    """Two-way distance between a surface before and after an edit, in the unit of the points.

    removed  reach of the faces that are gone from the surface that is left.
    added    reach of the new faces from the surface that was.
    diagonal of the surface before.
    """

    removed: Reach
    added: Reach
    diagonal: float

    @property
    def hausdorff(self) -> float:
        """The two-way Hausdorff distance, attained by a point of either surface."""
        return max(self.removed.attained, self.added.attained)

    @property
    def bound(self) -> float:
        """What the Hausdorff distance certainly does not exceed."""
        return max(self.removed.bound, self.added.bound)

    @property
    def share(self) -> float:
        """`hausdorff` as a share of the diagonal."""
        return self.hausdorff / self.diagonal if self.diagonal > 0.0 else 0.0


def shape_change(before: Surface, after: Surface) -> ShapeChange:
    """The distance both ways; faces with the same three corners on either side lie at none and cost nothing.

    Infinite when nothing is left, or nothing was there, to measure against.
    """
    gone, new = changed_faces(before, after)
    size = diagonal(before[0][np.unique(before[1])])
    return ShapeChange(_reach(gone, before, after, size), _reach(new, after, before, size), size)


def changed_faces(before: Surface, after: Surface) -> tuple[FloatArray, FloatArray]:
    """(m,) True for faces of `before` that `after` lacks, and the other way round; winding does not matter."""
    own, other = _face_numbers(*before), _face_numbers(*after)
    return ~np.isin(own, other), ~np.isin(other, own)


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


def _reach(moved: FloatArray, mine: Surface, theirs: Surface, size: float) -> Reach:
    if not moved.any():
        return NO_REACH
    if not triangle_areas(theirs[0][theirs[1]]).any():
        return Reach(np.inf, np.inf, mine[0][mine[1][moved][0, 0]])
    return reach(mine[0][mine[1][moved]], *theirs, TOLERANCE_SHARE * size)
