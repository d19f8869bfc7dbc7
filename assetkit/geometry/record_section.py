"""The geometry section of the record, from canonical meshes, physical surface and repairs (metres, m3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assetkit.geometry.physical_surface import PhysicalSurface
from assetkit.geometry.repair import RepairResult
from assetkit.geometry.triangle_budget import BudgetResult
from geom.features.shape_descriptor import shape_descriptor
from geom.mesh.edit import merge_surfaces
from geom.pose import quat_of
from schemas.arrays import FloatArray
from schemas.asset import AnnotationFrame, GeometrySection, quat4, vec3
from schemas.evidence import Evidence, inferred, measured
from schemas.model import Mesh

_VOLUME_CONFIDENCE = {
    "union_and_hulls": 0.5,
    "voxel": 0.5,
    "declared_shell": 0.9,
    "inferred_shell": 0.3,
    "default_shell": 0.3,
    "union_and_declared_walls": 0.9,
    "union_and_inferred_walls": 0.3,
    "union_and_default_walls": 0.3,
    "hull": 0.1,
}

CORE_TEXT = "an inner shell wound like the one around it counts as filled, but may be a cavity that lost its winding"
CORE_CONFIDENCE = 0.5  # Two readings, equally likely.


def geometry_section(
    meshes: Sequence[Mesh],
    physical: PhysicalSurface,
    unit: Evidence[float],
    mended: RepairResult,
    light: BudgetResult,
    R_AS: FloatArray,
    offset: FloatArray,
) -> GeometrySection:
    """What was measured on the canonical `meshes`; `R_AS` (3, 3) and `offset` (3,) are the axes and the origin of the
    source, seen from the asset frame.
    """
    points = np.concatenate([m.points for m in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    extent = vec3(high - low)
    bounds = None
    if unit.bounds is not None:
        factors = [b / unit.value for b in unit.bounds]
        bounds = (vec3((high - low) * factors[0]), vec3((high - low) * factors[1]))
    off = physical.distance
    return GeometrySection(
        extent_m=Evidence(
            value=extent,
            source="measured" if unit.source == "declared" else unit.source,
            method=f"bounding box of the render mesh; unit: {unit.method}",
            confidence=unit.confidence,
            bounds=bounds,
        ),
        origin_offset_m=vec3(offset),
        source_quat_wxyz=quat4(quat_of(R_AS)),
        annotation_frame=AnnotationFrame(
            centre_m=vec3((low + high) / 2), scale_m=float(np.linalg.norm(high - low)) or 1.0
        ),
        observed=mended.observed,
        reobserved=mended.reobserved,
        solid_kind=physical.solid.kind,
        volume_m3=_volume(physical, unit.confidence),
        surface_area_m2=physical.area_m2,
        wall_thickness_m=physical.wall,
        repaired_distance_m=_repaired_distance(mended, light),
        solid_distance_m=measured(
            off.attained,
            "largest distance of the physical surface from the visible one, and of visible parts outside it",
            bounds=(off.attained, off.bound),
        ),
        shape=shape_descriptor(*merge_surfaces(meshes)[:2]),
    )


def _volume(physical: PhysicalSurface, unit_confidence: float) -> Evidence[float]:
    """The volume by the method of the solid; with shells inside that may be cavities, down to what is left then.

    Walls beside closed bodies are as uncertain as their thickness, the bodies are not.
    """
    volume, core = physical.volume_m3, physical.solid.core
    if core is not None:
        method = f"{physical.method}; {CORE_TEXT}"
        return inferred(volume, method, CORE_CONFIDENCE * unit_confidence, bounds=(volume - core.volume_m3, volume))
    if physical.method == "union":
        return measured(volume, physical.method, confidence=unit_confidence)
    walls, wall = physical.solid.walls, physical.wall
    if walls is not None and wall is not None:
        share = walls.volume_m3 / volume
        trust = 1.0 - share + share * _VOLUME_CONFIDENCE[physical.method]
        least, most = (bound / wall.value - 1.0 for bound in wall.bounds or (wall.value, wall.value))
        bounds = (volume + least * walls.volume_m3, volume + most * walls.volume_m3)
        return inferred(volume, physical.method, trust * unit_confidence, bounds=bounds)
    return inferred(volume, physical.method, _VOLUME_CONFIDENCE[physical.method] * unit_confidence)


def _repaired_distance(mended: RepairResult, light: BudgetResult) -> Evidence[float]:
    """Two-way distance between the visible surface as read and as released; reductions add to the edits."""
    lost = sum(d.hausdorff for d in light.distortions)
    return measured(
        max(mended.change.hausdorff, lost),
        "two-way Hausdorff distance: changed faces by branch and bound"
        + (", reduction by its vertices and samples" if light.distortions else ""),
        bounds=(max(mended.change.hausdorff, lost), mended.change.bound + lost),
    )
