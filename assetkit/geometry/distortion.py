"""Distortion of a repair: how far it may have moved a surface from the true one (metres), and when a person decides.

The two-way Hausdorff distance before and after is recorded for every repair, but it is not what is judged where the
defect itself explains it: the middle of a filled hole is far from the rim, the tip of a removed fin far from the solid,
however right both edits are. What counts is what remains uncertain (`Edit.uncertainty`): the bulge a cap may lack, a
removed sheet too large to be a stray. Where an edit states none, the whole distance counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.geometry.edit import Counts, Edit
from geom.mesh.edit import merge_surfaces
from geom.mesh.hausdorff import ZERO_DISTANCE, one_sided_hausdorff
from geom.mesh.weld import diagonal
from geom.repair.shape_change import EDIT_TOLERANCE_SHARE, changed_faces, shape_change
from geom.solid.self_intersections import SelfIntersection
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Mesh

# A repair that may have moved the surface by more than this share of the diagonal goes to review.
DISTORTION_BOUND = 0.01


@dataclass(frozen=True)
class Distortion:
    """What one repair did to the shape, lengths in metres.

    hausdorff  two-way distance between all meshes before and after, attained by some point.
    length     the part of it that counts, largest at the point `at` (3,) of mesh `mesh` where these are known.
    diagonal   of all meshes before.
    """

    repair: str
    hausdorff: float
    length: float
    diagonal: float
    mesh: str | None = None
    at: FloatArray | None = None

    @property
    def share(self) -> float:
        """`length` as a share of the diagonal."""
        return self.length / self.diagonal if self.diagonal > 0.0 else 0.0

    def figures(self) -> tuple[Counts, Counts]:
        """Figures before and after for the `Repair`."""
        after = {
            "hausdorff_m": self.hausdorff,
            "hausdorff_share": self.hausdorff / self.diagonal if self.diagonal > 0.0 else 0.0,
            "distortion_m": self.length,
            "distortion_share": self.share,
        }
        return dict.fromkeys(after, 0.0), after


def distortion(repair: str, before: Sequence[Mesh], after: Sequence[Mesh], edits: Sequence[Edit]) -> Distortion:
    """What the reported `edits`, one per mesh, did on the way from meshes `before` to `after`."""
    change = shape_change(merge_surfaces(before)[:2], merge_surfaces(after)[:2])
    reported = [i for i, edit in enumerate(edits) if edit.before is not None]
    uncertainties = [
        (uncertainty, before[i].name) for i in reported if (uncertainty := edits[i].uncertainty) is not None
    ]
    if len(uncertainties) == len(reported):
        uncertainty, mesh = max(uncertainties, key=lambda pair: pair[0].length)
        return Distortion(repair, change.hausdorff, uncertainty.length, change.diagonal, mesh, uncertainty.at)
    furthest = max(change.removed, change.added, key=lambda way: way.attained)
    mesh = before[reported[0]].name if len(reported) == 1 else None
    return Distortion(repair, change.hausdorff, change.hausdorff, change.diagonal, mesh, furthest.at)


def crossing_distortion(crossings: Sequence[SelfIntersection], meshes: Sequence[Mesh]) -> Distortion:
    """What resolving bodies did to the physical surface: how far what was dropped reached out of what was kept."""
    size = diagonal(merge_surfaces(meshes)[0])
    worst = ZERO_DISTANCE
    for crossing in crossings:
        if crossing.resolved is not None:
            (points, triangles), surface = crossing.body, crossing.resolved.surface
            dropped_faces = changed_faces(crossing.body, surface)[0]
            dropped = one_sided_hausdorff(
                points[triangles[dropped_faces]], *surface, EDIT_TOLERANCE_SHARE * size, solid=True
            )
            worst = max(worst, dropped, key=lambda found: found.attained)
    return Distortion("self_intersection", worst.attained, worst.attained, size, None, worst.at)


def distortion_finding(distortion: Distortion, p_origin: FloatArray) -> Diagnostic | None:
    """The finding for review, None within the bound; `p_origin` (3,) is the origin of the asset frame."""
    if distortion.share <= DISTORTION_BOUND:
        return None
    place = ""
    if distortion.at is not None:
        place = " near ({:g}, {:g}, {:g})".format(*np.round(distortion.at - p_origin, 4))
    return finding(
        "asset/repair-distorts",
        f"'{distortion.repair}' may have moved the surface by {distortion.length:.3g} m{place}",
        where=Location(mesh=distortion.mesh),
        value=distortion.share,
        bound=DISTORTION_BOUND,
        unit="diagonals",
    )
