"""How far the physical surface of an asset lies from the visible one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geom.mesh.edit import merge_surfaces
from geom.mesh.hausdorff import Reach, reach
from geom.mesh.weld import diagonal
from geom.repair.shape_change import changed_faces
from schemas.model import Mesh
from schemas.physics import Solid

# Wider than for edits: united bodies cross the visible surface along whole curves.
TOLERANCE_SHARE = 1e-3
BUDGET = 50_000


@dataclass(frozen=True)
class SolidDistance:
    """Matter that the visible surface does not show, and visible parts that have none; lengths in metres.

    added    reach of the solid's surface from the visible one: caps, hulls, voxels.
    missing  reach of the visible surface out of the solid; what lies inside a closed solid is at no distance.
    """

    added: Reach
    missing: Reach

    @property
    def attained(self) -> float:
        """The larger distance, attained by some point."""
        return max(self.added.attained, self.missing.attained)

    @property
    def bound(self) -> float:
        """What neither distance exceeds."""
        return max(self.added.bound, self.missing.bound)


def solid_distance(meshes: Sequence[Mesh], solid: Solid) -> SolidDistance:
    """The distances between the visible `meshes` and their `solid`; faces that both have cost nothing."""
    points, triangles, _ = merge_surfaces(meshes)
    tolerance = TOLERANCE_SHARE * diagonal(points)
    left_out, added = changed_faces((points, triangles), (solid.points, solid.triangles))
    return SolidDistance(
        reach(solid.points[solid.triangles[added]], points, triangles, tolerance, budget=BUDGET),
        reach(
            points[triangles[left_out]],
            solid.points,
            solid.triangles,
            tolerance,
            solid=solid.kind != "shell",
            budget=BUDGET,
        ),
    )
