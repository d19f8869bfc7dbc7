"""Distances (m) between the visible meshes of an asset and its physical solid, in both directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geom.mesh.edit import merge_surfaces
from geom.mesh.hausdorff import DistanceBounds, one_sided_hausdorff
from geom.mesh.weld import diagonal
from geom.repair.shape_change import changed_faces
from schemas.model import Mesh
from schemas.physics import Solid

# Wider than for edits: united bodies cross the visible surface along whole curves.
SOLID_TOLERANCE_SHARE = 1e-3
SOLID_SEARCH_BUDGET = 50_000


@dataclass(frozen=True)
class SolidDistance:
    """Largest distances between a solid and the visible surface, in metres.

    added    from the solid's surface to the visible one: caps, hulls, voxels.
    missing  from the visible surface to the solid; points inside a closed solid have distance 0.
    """

    added: DistanceBounds
    missing: DistanceBounds

    @property
    def attained(self) -> float:
        """The larger distance, attained by some point."""
        return max(self.added.attained, self.missing.attained)

    @property
    def bound(self) -> float:
        """A proven upper bound of both distances."""
        return max(self.added.bound, self.missing.bound)


def solid_distance(meshes: Sequence[Mesh], solid: Solid) -> SolidDistance:
    """The distances between the visible `meshes` and their `solid`; faces that both have are skipped."""
    points, triangles, _ = merge_surfaces(meshes)
    tolerance = SOLID_TOLERANCE_SHARE * diagonal(points)
    left_out, added = changed_faces((points, triangles), (solid.points, solid.triangles))
    return SolidDistance(
        one_sided_hausdorff(
            solid.points[solid.triangles[added]], points, triangles, tolerance, budget=SOLID_SEARCH_BUDGET
        ),
        one_sided_hausdorff(
            points[triangles[left_out]],
            solid.points,
            solid.triangles,
            tolerance,
            solid=solid.kind != "shell",
            budget=SOLID_SEARCH_BUDGET,
        ),
    )
