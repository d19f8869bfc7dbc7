"""Stage 2, canonicalize: metres, z-up, bottom-centre origin; observe, repair, observe again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.options import Options
from assetkit.stage import Canonical, Draft, Intake, Tools
from assetkit.stages.distortion import distortion_finding
from assetkit.stages.repair_geometry import RepairResult, repair_geometry
from assetkit.stages.triangle_budget import Budgeted, within_budget
from assetkit.units import decide_unit
from assetkit.up_axis import TO_Z_UP, decide_up_axis
from assetkit.wall import with_wall
from geom.mesh_edit import only_used_points
from geom.solid import solidify
from geom.solid_distance import solid_distance
from geom.surface_distance import triangle_areas
from schemas.asset import AnnotationFrame, GeometrySection, Vec3
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.evidence import Evidence, inferred, measured
from schemas.model import FloatArray, Mesh
from schemas.outcome import Outcome, Repair
from schemas.physics import Solid

_VOLUME_CONFIDENCE = {
    "union_and_hulls": 0.5,
    "voxel": 0.5,
    "declared_shell": 0.9,
    "inferred_shell": 0.3,
    "default_shell": 0.3,
    "hull": 0.1,
}
FAR_DIAGONALS = 100.0  # Beyond this distance from its origin, float32 keeps fewer than five digits of the shape.


class Canonicalize:
    """Brings an object into its metric frame and mends what is broken; every edit has figures before and after."""

    name = "canonicalize"
    version = 2
    result = Canonical

    def accepts(self, draft: Draft) -> list[Diagnostic]:
        """Nothing forbids running: intake has screened the model."""
        return []

    def run(self, draft: Draft, tools: Tools) -> Outcome[Canonical]:
        """Canonical meshes, the physical surface and the geometry section."""
        return canonicalize(draft.intake, draft.source_name, tools.options)


def canonicalize(item: Intake, source_name: str, options: Options) -> Outcome[Canonical]:
    """The object of `item` in its metric frame; no value when its size is impossible."""
    model = item.model
    points = np.concatenate([m.points for m in model.meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    try:
        unit = decide_unit(
            stated=model.meters_per_unit,
            chosen=options.units,
            extent=item.file_extent,
            format_=item.format,
            name=f"{item.folder}/{Path(source_name).stem}",
            hints=model.hints,
            nodes=model.nodes,
        )
    except InvalidInput as refused:
        return Outcome(None, (refused.diagnostic,))
    up = decide_up_axis(model.up_axis, model.hints, options.up_axis)
    R_AS = TO_Z_UP[up.axis.value]
    far = _recentred(low, high)
    centred = [replace(m, points=m.points - far.shift) for m in model.meshes]
    posed = [_posed(m, R_AS, unit.meters_per_unit.value) for m in centred]
    mended = repair_geometry(posed)
    light = within_budget([only_used_points(m) for m in mended.meshes], options.max_triangles)
    homed, p_origin = _at_bottom_centre(light.meshes)
    solid, figures = solidify(homed)
    solid, wall = with_wall(
        solid,
        str(figures["method"]),
        homed,
        stated_m=options.shell_thickness_m,
        materials=model.materials,
        meters_per_unit=unit.meters_per_unit.value,
    )
    offset = -(p_origin + R_AS @ far.shift * unit.meters_per_unit.value)
    section = _section(homed, solid, figures, wall, unit.meters_per_unit, mended, light, offset)
    found = [distortion_finding(d, p_origin) for d in (*mended.distortions, *light.distortions)]
    distorted = tuple(f for f in found if f is not None)
    return Outcome(
        Canonical(tuple(homed), solid, unit.meters_per_unit, up.axis, section),
        (*unit.diagnostics, *up.diagnostics, *far.diagnostics, *mended.diagnostics, *light.diagnostics, *distorted),
        (*unit.repairs, *up.repairs, *far.repairs, *mended.repairs, *light.repairs),
        review=unit.review or up.review or bool(distorted),
    )


class _Recentring:
    """How far the object is moved before anything else, in double precision."""

    def __init__(self, shift: FloatArray, diagnostics: tuple[Diagnostic, ...], repairs: tuple[Repair, ...]) -> None:
        self.shift = shift
        self.diagnostics = diagnostics
        self.repairs = repairs


def _recentred(low: FloatArray, high: FloatArray) -> _Recentring:
    """Always centre; only an object far from its origin counts as repaired."""
    centre = (low + high) / 2
    ratio = float(np.linalg.norm(centre) / max(float(np.linalg.norm(high - low)), 1e-300))
    if ratio <= FAR_DIAGONALS:
        return _Recentring(centre, (), ())
    note = finding(
        "asset/far-from-origin",
        f"the object lies {ratio:.3g} times its own size from its origin",
        value=ratio,
        bound=FAR_DIAGONALS,
        unit="diagonals",
    )
    repair = Repair(
        name="recentre",
        code="asset/far-from-origin",
        stage="canonicalize",
        before={"distance_diagonals": ratio},
        after={"distance_diagonals": 0.0},
    )
    return _Recentring(centre, (note,), (repair,))


def _posed(mesh: Mesh, R_AS: FloatArray, meters_per_unit: float) -> Mesh:
    """The mesh turned z-up and scaled to metres; a rotation, so winding stays."""
    normals = mesh.normals
    return replace(
        mesh,
        points=(mesh.points @ R_AS.T) * meters_per_unit,
        normals=None if normals is None else (normals @ R_AS.T).astype(np.float32),
    )


def _at_bottom_centre(meshes: Sequence[Mesh]) -> tuple[list[Mesh], FloatArray]:
    """Meshes with the origin at the bottom centre of their bounding box, and where that point was before."""
    points = np.concatenate([m.points for m in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    origin = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return [replace(m, points=m.points - origin) for m in meshes], origin


def _section(
    meshes: Sequence[Mesh],
    solid: Solid,
    figures: dict,
    wall: Evidence[float] | None,
    unit: Evidence[float],
    mended: RepairResult,
    light: Budgeted,
    offset: FloatArray,
) -> GeometrySection:
    points = np.concatenate([m.points for m in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    extent = _vec3(high - low)
    bounds = None
    if unit.bounds is not None:
        factors = [b / unit.value for b in unit.bounds]
        bounds = (_vec3((high - low) * factors[0]), _vec3((high - low) * factors[1]))
    off = solid_distance(meshes, solid)
    area = float(triangle_areas(solid.points[solid.triangles]).sum())
    volume = float(figures["volume_m3"]) if wall is None else area * wall.value
    method = str(figures["method"]) if wall is None else f"{wall.source}_shell"
    return GeometrySection(
        extent_m=Evidence(
            value=extent,
            source="measured" if unit.source == "declared" else unit.source,
            method=f"bounding box of the render mesh; unit: {unit.method}",
            confidence=unit.confidence,
            bounds=bounds,
        ),
        origin_offset_m=_vec3(offset),
        annotation_frame=AnnotationFrame(
            centre_m=_vec3((low + high) / 2), scale_m=float(np.linalg.norm(high - low)) or 1.0
        ),
        observed=mended.observed,
        reobserved=mended.reobserved,
        solid_kind=solid.kind,
        volume_m3=(
            measured(volume, method, confidence=unit.confidence)
            if method == "union"
            else inferred(volume, method, _VOLUME_CONFIDENCE[method] * unit.confidence)
        ),
        surface_area_m2=area,
        wall_thickness_m=wall,
        repaired_distance_m=_repaired_distance(mended, light),
        solid_distance_m=measured(
            off.attained,
            "largest distance of the physical surface from the visible one, and of visible parts outside it",
            bounds=(off.attained, off.bound),
        ),
    )


def _repaired_distance(mended: RepairResult, light: Budgeted) -> Evidence[float]:
    """Two-way distance between the visible surface as read and as released; reductions add to the edits."""
    lost = sum(d.hausdorff for d in light.distortions)
    return measured(
        max(mended.change.hausdorff, lost),
        "two-way Hausdorff distance: changed faces by branch and bound"
        + (", reduction by its vertices and samples" if light.distortions else ""),
        bounds=(max(mended.change.hausdorff, lost), mended.change.bound + lost),
    )


def _vec3(v: FloatArray) -> Vec3:
    return (float(v[0]), float(v[1]), float(v[2]))
