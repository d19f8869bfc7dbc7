"""Mass, mass centre and inertia as the source states them: in the asset frame, checked against the geometry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from geom.convex.hull import contains, convex_hull, volume
from geom.mass.inertia import is_physical
from geom.mass.inertia_bounds import rms_distance_and_bound
from geom.mass.offset_centre import contracted_inertia, contraction_about, relative_depth
from geom.mesh.surface_distance import closest_on_surface
from geom.mesh.weld import diagonal
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.model import Mesh
from schemas.outcome import Repair
from schemas.physics import MassProperties, VolumeProperties
from schemas.stated_physics import StatedMass

CODE = "asset/source-inertia-implausible"
# Over the convex hull, for a thing is at least as heavy as the air in it; over the solid, a little above osmium.
LEAST_KGM3, MOST_KGM3 = 1.25, 25_000.0
GUESSED_VOLUME = 2.5  # The wall of a shell may be so much thicker than assumed.
CENTRE_SLACK = 0.005  # of the diagonal: visible meshes may be tighter than the thing.
SINGLE_PRECISION = 1e-4  # Files keep tensors in single precision.
# trace(I) / 2 is the sum of m r^2. Against the evenly filled solid: a hollow box has 5/3, a box of edges alone 7/3, a
# lamp with a lead foot a fifth.
LEAST_SPREAD, MOST_SPREAD = 0.15, 3.5
MOST_REACH = 0.9  # of what mass at the two ends of the object would give, along any axis
# A mass centre on the skin has all mass in that face; a lead sheet below a balsa box comes to 8 %. Of the way through.
LEAST_DEPTH = 0.01
MOST_APART = 0.2  # of the trace; a rod turned by 90 degrees is 0.5 off

Quantity = Literal["mass", "centre", "inertia"]


@dataclass(frozen=True)
class CheckedStatement:
    """A statement without its implausible quantities (None when the mass itself is implausible), and the findings.

    `squeeze` (3, 3) is the map that makes evenly spread mass fit about a mass centre stated without a usable tensor
    (`contraction_about`); None where it fits as it is.
    """

    stated: StatedMass | None
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    squeeze: FloatArray | None = None


@dataclass(frozen=True)
class _Objection:
    quantity: Quantity
    headline: str
    value: float
    bound: float
    unit: str

    @property
    def shown(self) -> float | str:
        """The value as data; JSON has no infinity."""
        return self.value if np.isfinite(self.value) else str(self.value)


def in_asset_frame(
    stated: StatedMass, R_AM: FloatArray, meters_per_unit: float, p_AoMo_A: FloatArray | Sequence[float]
) -> StatedMass:
    """`stated`, given in the model's frame M and units, in the asset frame A: metres, kg/m3, kg m2.

    R_AM (3, 3) turns model axes into asset axes, p_AoMo_A (3,) is the model's origin in metres.
    """
    s, scale = stated, meters_per_unit
    return replace(
        s,
        density=None if s.density is None else s.density / scale**3,
        centre=None if s.centre is None else R_AM @ s.centre * scale + np.asarray(p_AoMo_A),
        inertia=None if s.inertia is None else R_AM @ s.inertia @ R_AM.T * scale**2,
    )


def applicable_statements(
    masses: Sequence[StatedMass], meshes: Sequence[Mesh]
) -> tuple[list[StatedMass], list[Diagnostic]]:
    """The statements that cover these meshes (as read) and no others; a mass shared with others is reported.

    A density holds for any part of the meshes that it covers.
    """
    statements: list[StatedMass] = []
    notes: list[Diagnostic] = []
    for stated in masses:
        covered = sum(len(m.triangles) for m in meshes if m.source_path in stated.covers)
        if covered == stated.triangles or (covered and stated.mass_kg is None):
            statements.append(stated)
        elif covered:
            headline = "the stated mass counts for several separate objects; it was not used"
            figures = {"value": covered, "bound": stated.triangles, "unit": "triangles"}
            notes.append(finding(CODE, headline, where=stated.where, severity=Severity.INFO, **figures))
    return statements, notes


def check_statement(
    stated: StatedMass, points: FloatArray, part_volume: VolumeProperties, *, exact: bool
) -> CheckedStatement:
    """`stated` (asset frame) checked against the geometry that it covers.

    points       (n, 3) of its surface; the mass centre must lie in their hull, with 0.5 % of the diagonal to spare.
    part_volume  of the same geometry: bounds of the implied density, of the size and axes of the tensor.
    exact        `part_volume` is that of a closed surface of its own; otherwise its wall is a guess.

    An objection to the mass drops everything, one to the mass centre also the inertia, which is about it. A mass centre
    left without a tensor must lie below the skin, and the even filling is squeezed where it does not fit. The bounds
    are narrower than those of the static gate, so that a statement that is used here passes the gate.
    """
    objections = list(_objections(stated, points, part_volume, exact=exact))
    plausible = _without(stated, {o.quantity for o in objections})
    squeeze: FloatArray | None = None
    if (
        plausible is not None
        and plausible.mass_kg is not None
        and plausible.centre is not None
        and plausible.inertia is None
    ):
        filled = part_volume.filled(plausible.mass_kg / part_volume.volume_m3)
        squeeze, contradicted = _squeeze(plausible.centre, points, filled)
        if contradicted is not None:
            objections, plausible = [*objections, contradicted], replace(plausible, centre=None)
    notes = [
        finding(CODE, o.headline, where=stated.where, value=o.shown, bound=o.bound, unit=o.unit) for o in objections
    ]
    repairs: list[Repair] = []
    if objections:
        first = objections[0]
        repairs.append(
            Repair(
                name="implausible_inertia",
                code=CODE,
                stage="physics",
                before={"quantity": first.quantity, "value": first.shown, "bound": first.bound},
                after={"quantity": first.quantity, "value": "computed from the solid"},
            )
        )
    if squeeze is not None:
        headline = "no usable tensor is stated and an even filling does not fit about the stated mass centre: squeezed"
        even = part_volume.second_moment_m5
        share = float(np.trace(contracted_inertia(even, squeeze)) / np.trace(even))
        unit = "of the evenly filled"
        notes.append(
            finding(CODE, headline, where=stated.where, value=share, bound=1.0, unit=unit, severity=Severity.INFO)
        )
        repairs.append(
            Repair(
                name="squeezed_inertia",
                code=CODE,
                stage="physics",
                before={"trace_of_even": 1.0},
                after={"trace_of_even": share},
            )
        )
    return CheckedStatement(plausible, tuple(notes), tuple(repairs), squeeze)


def _without(stated: StatedMass, dropped: set[Quantity]) -> StatedMass | None:
    if not dropped:
        return stated
    if "mass" in dropped:
        return None
    if stated.mass_kg is None:
        return stated
    return replace(stated, centre=None if "centre" in dropped else stated.centre, inertia=None)


def _squeeze(
    centre: FloatArray, points: FloatArray, even: MassProperties
) -> tuple[FloatArray | None, _Objection | None]:
    """The squeeze of the evenly filled body (`even`, of the stated mass) that lets it have this mass centre, if needed;
    or the objection to the centre: it lies on the skin, or no tensor about it would be plausible.
    """
    depth = relative_depth(centre, points, even.centre_of_mass_m)
    if depth < LEAST_DEPTH:
        headline = "the stated mass centre lies on the skin of the object"
        return None, _Objection("centre", headline, depth, LEAST_DEPTH, "of the way through the object")
    if not list(_about_inertia(even.inertia_kgm2, even, points - centre)):
        return None, None
    S = contraction_about(centre, points, even.centre_of_mass_m, even.inertia_kgm2 / even.mass_kg)
    doubt = next(_about_inertia(contracted_inertia(even.inertia_kgm2, S), even, points - centre), None)
    if doubt is None:
        return S, None
    headline = "no plausible tensor fits about the stated mass centre"
    return None, _Objection("centre", headline, doubt.value, doubt.bound, doubt.unit)


def _objections(
    stated: StatedMass, points: FloatArray, part_volume: VolumeProperties, *, exact: bool
) -> Iterator[_Objection]:
    """The implausible quantities, the gravest first; later quantities are only checked while earlier ones hold."""
    mass = stated.mass_kg
    what, unit, value = ("density", "kg/m3", stated.density) if mass is None else ("mass", "kg", mass)
    if value is None:
        return
    if not (np.isfinite(value) and value > 0.0):
        yield _Objection("mass", f"the stated {what} is not positive and finite", float(value), 0.0, unit)
        return
    filled, hull = part_volume.volume_m3, max(part_volume.volume_m3, _hull_volume(points))
    most = MOST_KGM3 if exact or mass is None else GUESSED_VOLUME * MOST_KGM3
    densest = value if mass is None else mass / filled if filled > 0.0 else np.inf
    lightest = value * filled / hull if mass is None else mass / hull if hull > 0.0 else np.inf
    if densest > most or lightest < LEAST_KGM3:
        headline = f"the stated {what} means a density that no object has"
        shown, bound = (densest, most) if densest > most else (lightest, LEAST_KGM3)
        yield _Objection("mass", headline, float(shown), bound, "kg/m3")
        return
    if mass is None:
        return
    size = diagonal(points)
    if stated.centre is not None:
        outside = _distance_outside(stated.centre, points)
        if not outside <= CENTRE_SLACK * size:
            headline = "the stated mass centre lies outside the object"
            yield _Objection("centre", headline, outside, CENTRE_SLACK * size, "m")
            return
    if stated.inertia is not None:
        centre = part_volume.centre_m if stated.centre is None else stated.centre
        yield from _about_inertia(stated.inertia, part_volume.filled(mass / filled), points - centre)


def _about_inertia(inertia: FloatArray, even: MassProperties, points: FloatArray) -> Iterator[_Objection]:
    """`even` is the evenly filled body of the stated mass, `points` (n, 3) its surface from the mass centre."""
    low, middle, high = np.linalg.eigvalsh(inertia) if np.isfinite(inertia).all() else (np.nan,) * 3
    if not low > 0.0:
        yield _Objection("inertia", "a stated moment of inertia is not positive", float(low), 0.0, "kg m2")
        return
    if not is_physical(inertia, SINGLE_PRECISION):
        headline = "a stated moment of inertia is above the sum of the others"
        yield _Objection("inertia", headline, float(high), float(low + middle), "kg m2")
        return
    ratio = float(np.trace(inertia) / np.trace(even.inertia_kgm2))
    if not LEAST_SPREAD <= ratio <= MOST_SPREAD:
        large = ratio > MOST_SPREAD
        headline = f"the stated inertia is too {'large' if large else 'small'} for the mass and size of the object"
        yield _Objection("inertia", headline, ratio, MOST_SPREAD if large else LEAST_SPREAD, "of the evenly filled")
        return
    # The shape of the tensor, whatever its size: axes swapped or turned show here.
    apart = np.abs(np.linalg.eigvalsh(inertia / ratio - even.inertia_kgm2)).max() / np.trace(even.inertia_kgm2)
    if apart > MOST_APART:
        headline = "the stated inertia lies along other axes than the shape"
        yield _Objection("inertia", headline, float(apart), MOST_APART, "of the trace")
        return
    reach, most = rms_distance_and_bound(inertia / even.mass_kg, points)
    if reach > MOST_REACH * most > 0.0:
        headline = "the stated inertia needs mass outside the object"
        yield _Objection("inertia", headline, reach, MOST_REACH * most, "m")


def _hull_volume(points: FloatArray) -> float:
    try:
        return volume(*convex_hull(points))
    except ValueError:
        return 0.0


def _distance_outside(point: FloatArray, points: FloatArray) -> float:
    """How far `point` lies outside the convex hull of `points`, or outside their bounding box when they are flat."""
    if not np.isfinite(point).all():
        return float("inf")
    try:
        hull = convex_hull(points)
    except ValueError:
        beyond = np.maximum(np.maximum(points.min(axis=0) - point, point - points.max(axis=0)), 0.0)
        return float(np.linalg.norm(beyond))
    if contains(*hull, point[None])[0]:
        return 0.0
    return float(np.linalg.norm(closest_on_surface(point[None], *hull)[0][0] - point))
