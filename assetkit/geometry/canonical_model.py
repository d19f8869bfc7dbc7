"""Canonical meshes of one object in metres, z up, origin at the bottom centre, repaired; with the geometry section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.geometry.canonical_bodies import joined, mend_bodies
from assetkit.geometry.distortion import Distortion, distortion_finding
from assetkit.geometry.joint_damping import DampingResult, plausible_damping
from assetkit.geometry.physical_surface import at_origin, physical_surface
from assetkit.geometry.record_section import geometry_section
from assetkit.options import Options
from assetkit.pose.up_axis import TO_Z_UP, decide_up_axis
from assetkit.scale.declared_units import decide_unit
from assetkit.stage import Canonical, Frame, Intake, LinkSurface
from geom.mechanism_pose import in_frame
from geom.solid.self_intersections import MISCOUNTED_SHARE, SelfIntersection
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.model import Mesh, Model
from schemas.outcome import Outcome, Repair

FAR_DIAGONALS = 100.0  # Beyond this distance from its origin, float32 keeps fewer than five digits of the shape.


def canonicalize(item: Intake, source_name: str, options: Options, frame: Frame | None = None) -> Outcome[Canonical]:
    """The object of `item` in its metric frame, or in `frame` that semantics gives it; no value when its size is
    impossible.
    """
    model = item.model
    points = np.concatenate([m.points for m in model.meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    try:
        unit = decide_unit(
            stated=model.meters_per_unit,
            chosen=options.units,
            chosen_by=options.origin("units"),
            extent=item.file_extent,
            format_=item.format,
            name=f"{item.folder}/{Path(source_name).stem}",
            hints=model.hints,
            nodes=model.nodes,
        )
    except InvalidInput as refused:
        return Outcome(None, (refused.diagnostic,))
    up = decide_up_axis(model.up_axis, model.hints, options.up_axis, options.origin("up_axis"))
    R_AS = TO_Z_UP[up.axis.value] if frame is None else frame.R_AS
    unit = frame.unit if frame is not None and frame.unit is not None else unit
    given = frame or Frame(R_AS)
    far = _recentred(low, high)
    centred = [replace(m, points=m.points - far.shift) for m in model.meshes]
    posed = [_posed(m, R_AS, unit.meters_per_unit.value) for m in centred]
    bodies = mend_bodies(posed, options.max_triangles)
    if not all(any(len(mesh.triangles) for mesh in body.mended.bodies.tidied) for body in bodies):
        return Outcome(
            None, (finding("asset/degenerate-geometry", "no face of a body keeps an area when it is cleaned"),)
        )
    p_origin = _bottom_centre([m for body in bodies for m in body.light.meshes])
    scale = unit.meters_per_unit.value
    surfaces = [
        physical_surface(
            body.mended, body.light, p_origin, options=options, materials=model.materials, meters_per_unit=scale
        )
        for body in bodies
    ]
    whole = joined(posed, bodies, surfaces)
    mended, light, physical = whole.mended, whole.light, whole.physical
    homed = at_origin(light.meshes, p_origin)
    offset = -(p_origin + R_AS @ far.shift * unit.meters_per_unit.value)
    section = geometry_section(homed, physical, unit.meters_per_unit, mended, light, R_AS, offset)
    joints = _mechanism(model, R_AS, scale, offset, homed)
    edits = (*mended.diagnostics, *light.diagnostics, *physical.diagnostics)
    for_review = _review_findings(
        (*mended.distortions, *light.distortions, *physical.distortions), mended.unresolved, p_origin
    )
    return Outcome(
        Canonical(
            homed,
            physical.solid,
            unit.meters_per_unit,
            up.axis,
            section,
            R_AS,
            joints.mechanism if joints is not None else None,
            tuple(LinkSurface(b.link, s.solid, s.wall) for b, s in zip(bodies, surfaces, strict=True) if b.link),
        ),
        (
            *(*unit.diagnostics, *up.diagnostics, *given.diagnostics, *far.diagnostics, *edits, *for_review),
            *(joints.diagnostics if joints is not None else ()),
        ),
        (
            *(*unit.repairs, *up.repairs, *given.repairs, *far.repairs, *physical.repairs, *light.repairs),
            *(joints.repairs if joints is not None else ()),
        ),
        review=unit.review or up.review or bool(for_review),
    )


def _mechanism(
    model: Model, R_AS: FloatArray, scale: float, offset: FloatArray, meshes: Sequence[Mesh]
) -> DampingResult | None:
    """The mechanism of a model in the asset frame, with plausible damping; its root's frame is that frame at rest."""
    if model.mechanism is None:
        return None
    placed = in_frame(model.mechanism, R_AS, scale, offset)
    rooted = replace(placed, links=(replace(placed.root, origin=np.zeros(3)), *placed.links[1:]))
    return plausible_damping(rooted, meshes)


def _review_findings(
    distortions: Sequence[Distortion], unresolved: Sequence[SelfIntersection], p_origin: FloatArray
) -> tuple[Diagnostic, ...]:
    """Findings for review: repairs that may distort the shape, bodies that could not be resolved."""
    distorting = [distortion_finding(d, p_origin) for d in distortions]
    left = [
        finding(
            "asset/self-intersection",
            "a closed surface passes through itself and could not be resolved",
            value=crossing.miscounted_share,
            bound=MISCOUNTED_SHARE,
            unit="of its volume",
        )
        for crossing in unresolved
    ]
    return (*(f for f in distorting if f is not None), *left)


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


def _bottom_centre(meshes: Sequence[Mesh]) -> FloatArray:
    """(3,) the bottom centre of the bounding box."""
    points = np.concatenate([m.points for m in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
