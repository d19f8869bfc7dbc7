"""Chooses the collision shapes of a solid: the simplest candidate within tolerance of its surface and its openings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from assetkit.colliders.decompose import DecompositionSettings, decompose, open_through
from geom.convex.hull import convex_hull, extreme_points
from geom.convex.primitive_fits import fit_box, fit_capsule, fit_cylinder, fit_sphere
from geom.decomposition.fidelity import ReferenceSurface, measure_fidelity, reference_surface
from geom.decomposition.simplified_body import SimplifiedBody, simplify_body
from geom.features.cavities import Cavity, find_cavities
from geom.features.resting_planes import hull_within, resting_planes
from geom.mesh.decimate import decimate
from geom.solid.solid_volume import PLATE_WALL_M
from geom.solid.thicken import thicken
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.physics import CollisionShape, Fidelity, Solid

SHEET_FACES = 1500
# More hull corners do not change the fit; the oriented box would take a minute for ten times as many.
MOST_CORNERS = 2000


@dataclass(frozen=True)
class Tolerance:
    """Bounds a candidate must meet; distances are shares of the diagonal.

    p95     95th percentile of the surface distance, both ways.
    max     largest surface distance, both ways: a knob that nothing touches is a knob that is not there.
    volume  least and greatest ratio of volumes (not checked for sheets, whose wall is assumed).
    """

    p95: float
    max: float
    volume: tuple[float, float]


ANALYTIC = Tolerance(p95=0.015, max=0.05, volume=(0.93, 1.07))
HULL = Tolerance(p95=0.02, max=0.06, volume=(0.95, 1.15))
PARTS = Tolerance(p95=0.02, max=0.08, volume=(0.95, 1.15))

WITHIN = "within tolerance"


@dataclass(frozen=True)
class ToleranceViolation:
    """A violated bound: in words, the figure (None without one), its bound and unit, and the factor between the two."""

    text: str
    value: float | None
    bound: float | None
    unit: str
    by: float


Fit = Callable[[FloatArray], CollisionShape | None]


def _fit_hull(points: FloatArray) -> CollisionShape | None:
    """The convex hull of points (n, 3), flat where the body can rest; None when they span no volume."""
    return hull_within(points, resting_planes(points))


# Tried in this order; the first within tolerance is taken.
SINGLE_SHAPES: tuple[tuple[str, Fit, Tolerance], ...] = (
    ("box", fit_box, ANALYTIC),
    ("sphere", fit_sphere, ANALYTIC),
    ("capsule", fit_capsule, ANALYTIC),
    ("cylinder", fit_cylinder, ANALYTIC),
    ("hull", _fit_hull, HULL),
)
SECTORS, CUTS, CUTS_AROUND, CUTS_EVEN, COACD, COACD_COARSE, VHACD, CUTS_FINE = (
    "sectors",
    "cuts",
    "cuts_around",
    "cuts_even",
    "coacd",
    "coacd_coarse",
    "vhacd",
    "cuts_fine",
)
DECOMPOSITIONS: tuple[tuple[str, DecompositionSettings], ...] = (
    (SECTORS, DecompositionSettings(method="sectors", sector_planes=8)),
    (CUTS, DecompositionSettings(method="cuts")),
    (CUTS_AROUND, DecompositionSettings(method="cuts", sector_planes=4)),
    (CUTS_EVEN, DecompositionSettings(method="cuts", balance=2.0)),
    (COACD, DecompositionSettings()),
    (COACD_COARSE, DecompositionSettings(threshold=0.08, search_nodes=8, search_iterations=20)),
    (VHACD, DecompositionSettings(method="vhacd")),
    (CUTS_FINE, DecompositionSettings(method="cuts", max_hulls=64, max_pieces=400)),
)
METHODS = tuple(name for name, *_ in (*SINGLE_SHAPES, *DECOMPOSITIONS))
# 32 hulls cannot approximate many thin boards: where all violate a bound by this factor, twice as many are allowed.
FAR_OFF = 2.0


@dataclass(frozen=True)
class Colliders:
    """The chosen shapes with the method's name, every candidate tried, the openings found, and a warning if any."""

    method: str
    shapes: tuple[CollisionShape, ...]
    candidates: tuple[Fidelity, ...]
    cavities: tuple[Cavity, ...]
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class ColliderCandidate:
    """Shapes, none if the method failed, and their figures."""

    fidelity: Fidelity
    shapes: tuple[CollisionShape, ...] = ()


@dataclass(frozen=True)
class _Target:
    """The reference of all candidates; `own_volume`: its volume is that of the solid, not of an assumed wall."""

    solid: Solid
    cavities: tuple[Cavity, ...]
    own_volume: bool

    @cached_property
    def corners(self) -> FloatArray:
        """Points (n, 3) of the solid's hull, which single shapes depend on; at most `MOST_CORNERS`."""
        try:
            corners, _ = convex_hull(self.solid.points)
        except ValueError:
            return self.solid.points
        return corners if len(corners) <= MOST_CORNERS else corners[extreme_points(corners, MOST_CORNERS)]

    @cached_property
    def reference(self) -> ReferenceSurface:
        """The solid's outer surface, prepared for measuring."""
        return reference_surface(self.solid)

    @cached_property
    def body(self) -> SimplifiedBody | str:
        """The solid prepared for decomposition, or the reason why there is nothing to decompose."""
        try:
            return simplify_body(self.solid.points, self.solid.triangles)
        except ValueError as error:
            return str(error)


def choose_colliders(
    solid: Solid, work_dir: Path, exclude: frozenset[str] = frozenset(), cavities: tuple[Cavity, ...] | None = None
) -> Colliders:
    """The first candidate of `SINGLE`, then of `LADDER`, that meets its tolerance and keeps every opening.

    `exclude` names methods that must not be chosen again; `cavities` are those of the solid where they are known. When
    none passes, the one with the least violation stands in, one that keeps the openings before any that does not; with
    a warning, unless it is within the tolerance of parts. A sheet counts as a wall of its assumed thickness. Sectors
    are for rings, which are open from end to end, cuts around an axis for vessels. The two methods after CoACD are for
    bodies that no earlier method decomposed, the last for bodies where all violate a bound by far.
    """
    target = _target(solid, find_cavities(solid) if cavities is None else cavities)
    tried: list[ColliderCandidate] = []
    for method, fit, tolerance in SINGLE_SHAPES:
        shape = fit(target.corners) if method not in exclude else None
        if shape is not None:
            tried.append(_measured(method, (shape,), target, tolerance))
            if tried[-1].fidelity.accepted:
                return _chosen(tried, target)
    # A convex hull that stands in for a broken surface has nothing to decompose.
    methods = [entry for entry in DECOMPOSITIONS if entry[0] not in exclude] if solid.kind != "hull" else []
    for method, settings in methods:
        if method == SECTORS and not any(open_through(cavity) for cavity in target.cavities):
            continue
        if method == CUTS_AROUND and not any(not cavity.through for cavity in target.cavities):
            continue
        if method in (COACD_COARSE, VHACD) and any(len(c.shapes) > 1 for c in tried):
            continue
        if method == CUTS_FINE and not all(_is_far_off(c) for c in tried):
            break
        tried.append(_decomposed(method, settings, target, work_dir))
        if tried[-1].fidelity.accepted:
            break
    return _chosen(tried, target)


def _is_far_off(candidate: ColliderCandidate) -> bool:
    return not candidate.shapes or any(miss.by > FAR_OFF for miss in _violations(candidate.fidelity, PARTS))


def _decomposed(method: str, settings: DecompositionSettings, target: _Target, work_dir: Path) -> ColliderCandidate:
    if isinstance(target.body, str):
        return ColliderCandidate(failed_candidate(method, target.body, str(settings)))
    parts = decompose(target.body, settings, work_dir, cavities=target.cavities)
    if not parts.shapes:
        return ColliderCandidate(failed_candidate(method, parts.reason, str(settings)))
    candidate = _measured(method, parts.shapes, target, PARTS)
    return replace(candidate, fidelity=candidate.fidelity.model_copy(update={"settings": str(settings)}))


def _target(solid: Solid, cavities: tuple[Cavity, ...]) -> _Target:
    if solid.kind == "shell" and solid.wall_thickness_m is not None:
        points, triangles = decimate(solid.points, solid.triangles, SHEET_FACES)
        try:
            return _Target(Solid(*thicken(points, triangles, solid.wall_thickness_m), kind="closed"), cavities, False)
        except ValueError:
            return _Target(solid, (), False)
    return _Target(solid, cavities, solid.kind == "closed")


def _measured(
    method: str, shapes: tuple[CollisionShape, ...], target: _Target, tolerance: Tolerance
) -> ColliderCandidate:
    """The candidate measured and compared with `tolerance`; the reason names each violated bound."""
    f = measure_fidelity(method, shapes, target.reference, target.cavities)
    if not target.own_volume:
        f = f.model_copy(update={"volume_ratio": None})
    violations = _violations(f, tolerance)
    verdict = {"accepted": not violations, "reason": "; ".join(m.text for m in violations) or WITHIN}
    return ColliderCandidate(f.model_copy(update=verdict), shapes)


def _violations(f: Fidelity, tolerance: Tolerance) -> list[ToleranceViolation]:
    """Each violated bound."""
    violations = []
    low, high = tolerance.volume
    if f.volume_ratio is not None and not low <= f.volume_ratio <= high:
        bound, by = (low, low / max(f.volume_ratio, 1e-9)) if f.volume_ratio < low else (high, f.volume_ratio / high)
        text = f"volume ratio {f.volume_ratio:.3f} outside {low:g} to {high:g}"
        violations.append(ToleranceViolation(text, f.volume_ratio, bound, "of the solid's volume", by))
    for name, value, bound in (
        ("outside p95", f.outside_p95, tolerance.p95),
        ("missing p95", f.missing_p95, tolerance.p95),
        ("outside max", f.outside_max, tolerance.max),
        ("missing max", f.missing_max, tolerance.max),
    ):
        if value > bound:
            violations.append(
                ToleranceViolation(
                    f"{name} {value:.4f} above {bound:g}", value, bound, "of the diagonal", value / bound
                )
            )
    if f.cavity_kept is False:
        text = "lets a ball out of an opening through its wall" if f.cavity_open else "fills an opening"
        violations.append(ToleranceViolation(text, None, None, "", np.inf))
    return violations


def failed_candidate(method: str, reason: str, settings: str = "") -> Fidelity:
    """The row of a candidate without shapes and figures, with the reason."""
    return Fidelity(
        method=method,
        shapes=0,
        vertices=0,
        volume_ratio=None,
        outside_p95=1.0,
        outside_max=1.0,
        missing_p95=1.0,
        missing_max=1.0,
        cavity_kept=None,
        accepted=False,
        reason=reason,
        settings=settings,
    )


def _chosen(tried: Sequence[ColliderCandidate], target: _Target) -> Colliders:
    """The accepted candidate, which is the last tried, or the best of all with a warning."""
    usable = [c for c in tried if c.shapes]
    if not usable:
        usable = [
            ColliderCandidate(failed_candidate("plate", "no candidate has a volume"), (_plate(target.solid.points),))
        ]
        tried = [*tried, *usable]
    rows = tuple(c.fidelity for c in tried)
    best = min(usable, key=_badness)
    f = best.fidelity
    violations = sorted(_violations(f, PARTS), key=lambda miss: -miss.by)
    # A single shape that is too coarse for one is still as good as the parts would have to be.
    if f.accepted or not violations:
        rows = tuple(row.model_copy(update={"accepted": True, "reason": WITHIN}) if row is f else row for row in rows)
        return Colliders(f.method, best.shapes, rows, target.cavities)
    worst = violations[0]
    warning = finding(
        "asset/collision-fallback",
        f"No collision candidate meets its tolerance; '{f.method}' stands in: "
        + "; ".join(miss.text for miss in violations),
        value=worst.value,
        bound=worst.bound,
        unit=worst.unit,
        because=tuple(
            finding("asset/collision-fallback", f"{row.method}: {row.reason}") for row in rows if row.method != f.method
        ),
    )
    return Colliders(f.method, best.shapes, rows, target.cavities, (warning,))


def _badness(candidate: ColliderCandidate) -> tuple[bool, bool, float]:
    """Sort key: accepted first, then those that keep the openings, then by the greatest violation over its bound."""
    f = candidate.fidelity
    low, high = PARTS.volume
    ratio = f.volume_ratio if f.volume_ratio is not None else 1.0
    worst = max(
        max(f.outside_p95, f.missing_p95) / PARTS.p95,
        max(f.outside_max, f.missing_max) / PARTS.max,
        (ratio - 1.0) / (high - 1.0),
        (1.0 - ratio) / (1.0 - low),
    )
    return not f.accepted, f.cavity_kept is False, worst


def _plate(points: FloatArray) -> CollisionShape:
    """An oriented box around flat points, as thick as a plate (`PLATE_WALL_M`)."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    centred = points - middle
    axes = np.linalg.eigh(centred.T @ centred)[1]
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    along = centred @ axes
    X_AB = np.eye(4)
    X_AB[:3, :3] = axes
    X_AB[:3, 3] = middle + axes @ (0.5 * (along.min(axis=0) + along.max(axis=0)))
    size = np.maximum(np.ptp(along, axis=0), PLATE_WALL_M)
    return CollisionShape("box", (float(size[0]), float(size[1]), float(size[2])), X_AB)
