"""Bounds (kg) of the mass of an object around its estimate, with causes: material, hollowness, walls, unit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.mass.substances import STATED_TOLERANCE, Substance
from assetkit.mass.wall_thickness import SHEET_WALL_FACTORS
from assetkit.taxonomy.material_classes import UNKNOWN
from geom.convex.hull import convex_hull, volume
from geom.features.cavities import Cavity
from geom.mesh.components import components_of
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import diagonal, weld_points
from schemas.arrays import FloatArray
from schemas.evidence import Evidence
from schemas.physics import Solid

# Mass bounds further apart than this factor are useless to a randomiser.
MAX_SPAN = 30.0
# A stated density weighs the shape that the engine fills with it, so the volume counts as known to 5 %.
STATED_VOLUME_TOLERANCE = 0.05
# The thinnest walls of hollow things: share of the diagonal and its limits; nothing is lighter than cardboard.
HOLLOW_WALL_PER_DIAGONAL, LEAST_HOLLOW_WALL_M, MOST_HOLLOW_WALL_M = 0.005, 0.3e-3, 3e-3
LEAST_WALL_KGM3 = 400.0
# A cavity this large (share of the hull) behind walls this thin (share of the diagonal): the model shows the walls.
CAVITY_SHARE, MODELLED_WALL_SHARE = 0.2, 0.06
# A solid whose mean thickness is below this share of its diagonal has no room to be hollow.
SOLID_THROUGHOUT_SHARE = 0.03
# A hull holds at most its own volume and often a third of it.
HULL_FILL = 0.3
# Two bounds agree when they share this much (in the logarithm) of the narrower.
AGREEMENT, MODELLED_WALL_FACTOR = 0.5, 1.5


@dataclass(frozen=True)
class MassBounds:
    """Least and greatest plausible mass (kg), and the causes of the uncertainty.

    `span` is the ratio of the two before it was cut to `MAX_SPAN`.
    """

    low: float
    high: float
    causes: tuple[str, ...]
    span: float

    @property
    def text(self) -> str:
        """The reasons in words, and a note where the true uncertainty is wider than the bounds."""
        causes = f"bounds: {', '.join(self.causes)}" if self.causes else "bounds: spread of the material class"
        return causes + (
            f"; true spread {self.span:.3g}x, cut to {MAX_SPAN:g}x" if self.span > 1.001 * MAX_SPAN else ""
        )

    def union(self, other: MassBounds, cause: str, value: float) -> MassBounds:
        """Bounds around `value` that contain these and the `other` bounds; `cause` names the difference of the two."""
        low, high = min(self.low, other.low), max(self.high, other.high)
        both = _within_span(value, low, high, (1.0, 1.0), (*self.causes, cause))
        return replace(both, span=max(self.span, other.span, both.span))

    def clipped_to(self, category_range_kg: tuple[float, float], cause: str, value: float) -> MassBounds:
        """Bounds clipped to another range, but not past the estimate `value`; unchanged where the two do not overlap.

        `span` shrinks in proportion.
        """
        if not self.overlaps(category_range_kg):
            return self
        low, high = min(max(self.low, category_range_kg[0]), value), max(min(self.high, category_range_kg[1]), value)
        if (low, high) == (self.low, self.high):
            return self
        span = self.span * (high / low) / (self.high / self.low)
        return MassBounds(low, high, (*self.causes, cause), span)

    def intersected_with(self, other: MassBounds) -> MassBounds:
        """The intersection of both; these bounds alone when it is less than half of the narrower (in the logarithm).

        The `other` is widened first by the usual error of wall thickness in a model (`MODELLED_WALL_FACTOR`).
        """
        least, most = other.low / MODELLED_WALL_FACTOR, other.high * MODELLED_WALL_FACTOR
        low, high = max(self.low, least), min(self.high, most)
        narrower = min(self.high / self.low, most / least)
        if high <= low or math.log(high / low) < AGREEMENT * math.log(narrower):
            return replace(self, causes=(*self.causes, "what names say of the material does not agree"))
        return MassBounds(low, high, (*self.causes, *other.causes), min(self.span, other.span))

    def overlaps(self, range_kg: tuple[float, float]) -> bool:
        """Whether the bounds and the range have a mass in common."""
        return self.low <= range_kg[1] and range_kg[0] <= self.high

    def ratios(self, value: float) -> tuple[float, float]:
        """Low and high as factors on the estimate."""
        return self.low / value, self.high / value


@dataclass(frozen=True)
class FillFactors:
    """Factors on density that the shape allows (1 is the volume filled throughout).

    `low` and `high` hold for all substances, for the reasons in `causes`; `hollow` is the least share of the volume
    that is material where a substance may be hollow.
    """

    low: float = 1.0
    high: float = 1.0
    hollow: float = 1.0
    causes: tuple[str, ...] = ()


def mass_bounds(
    substances: Sequence[Substance],
    volumes_m3: Sequence[float],
    masses_kg: Sequence[float],
    filling: FillFactors,
    unit: Evidence[float],
    *,
    exact: bool = True,
) -> MassBounds:
    """Bounds around the sum of `masses_kg`, at most a factor of 30 apart.

    Each substance, with its volume in `volumes_m3`, from its least to its greatest density times the `filling` of the
    solid; when the volumes are not `exact` (shares by visible area), all of the volume could be any of the substances.
    Masses and densities that the source states vary by 10 % only. An uncertain unit scales the rest by its cube, as far
    as the factor of 30 leaves room.
    """
    rows = list(zip(substances, volumes_m3, masses_kg, strict=True))
    stated = sum(mass for substance, _, mass in rows if substance.stated is not None)
    free = [(substance, amount) for substance, amount, _ in rows if substance.stated is None]
    ranges = [_density_range(substance, filling) for substance, _ in free]
    amounts = [amount for _, amount in free]
    low = sum(amount * least for amount, (least, _) in zip(amounts, ranges, strict=True))
    high = sum(amount * most for amount, (_, most) in zip(amounts, ranges, strict=True))
    causes = [
        *(["stated mass, 10 % either way"] if stated else []),
        *(["stated density, 10 % either way, times volume, 5 %"] if any(_is_declared(s) for s, _ in free) else []),
        *(["material unknown"] if any(_is_unknown(s) for s, _ in free) else []),
        *(["may be hollow"] if filling.hollow < 1.0 and any(s.may_be_hollow for s, _ in free) else []),
        *(filling.causes if free else ()),
    ]
    if len(free) > 1 and not exact:
        low, high = sum(amounts) * min(r[0] for r in ranges), sum(amounts) * max(r[1] for r in ranges)
        causes.append("materials shared out by visible area")
    low, high = low + (1.0 - STATED_TOLERANCE) * stated, high + (1.0 + STATED_TOLERANCE) * stated
    return _within_span(sum(masses_kg), low, high, _unit_factors(unit) if free else (1.0, 1.0), causes)


def bounds_around(value: float, low: float, high: float, unit: Evidence[float], cause: str) -> MassBounds:
    """Bounds of a mass (kg) known for other reasons than its volume; an uncertain unit scales them by its cube."""
    return _within_span(value, low, high, _unit_factors(unit), (cause,))


def fill_factors(solid: Solid, wall: Evidence[float] | None, cavities: Sequence[Cavity]) -> FillFactors:
    """Bounds from shape alone on the share of `solid` that is material.

    Closed: as little as a wall of 0.5 % of the diagonal, unless the model shows its walls; without the content of inner
    shells that may be cavities; walls grown from sheets within the bounds of `wall`. Shell: within the bounds of
    `wall`; while that is a guess, up to a filled hull. Hull: filled to a third or fully.
    """
    if solid.kind == "hull":
        return FillFactors(low=HULL_FILL, causes=("convex hull stands in",))
    area = float(triangle_areas(solid.points[solid.triangles]).sum())
    if solid.kind == "shell":
        return _sheet_filling(solid, area, wall)
    full = volume(solid.points, solid.triangles)
    low, high, causes = 1.0, 1.0, ()
    if solid.core is not None:
        low = 1.0 - solid.core.volume_m3 / full
        causes = ("an inner shell may be a cavity that lost its winding",)
    thinnest = 0.0
    if solid.walls is not None:
        share, (thinner, thicker) = solid.walls.volume_m3 / full, wall_factors(wall)
        low, high, thinnest = low - share * (1.0 - thinner), 1.0 + share * (thicker - 1.0), share * thinner
        causes = (*causes, *wall_causes(wall))
    if _shows_walls(solid, cavities):
        return FillFactors(low, high, causes=causes)
    wall_m = min(max(HOLLOW_WALL_PER_DIAGONAL * diagonal(solid.points), LEAST_HOLLOW_WALL_M), MOST_HOLLOW_WALL_M)
    least = _bodies(solid)[1] * wall_m / full + thinnest
    return FillFactors(low, high, hollow=min(1.0, least / low), causes=causes)


def wall_factors(wall: Evidence[float] | None) -> tuple[float, float]:
    """Least and greatest factor on `wall` within which the true wall of sheets may lie."""
    if wall is None or wall.source == "default":
        return SHEET_WALL_FACTORS
    low, high = wall.bounds or (wall.value, wall.value)
    return low / wall.value, high / wall.value


def wall_causes(wall: Evidence[float] | None) -> tuple[str, ...]:
    """Why walls may be thinner or thicker; () when the source declares their thickness."""
    if wall is None or wall.source == "default":
        return ("wall thickness unknown",)
    return () if wall.source == "declared" else ("wall thickness inferred",)


def is_solid_throughout(solid: Solid, cavities: Sequence[Cavity]) -> bool:
    """Whether the shape leaves no room to be hollow: sheets, a solid that is thin throughout (plates, frames, tools;
    twice its volume over its surface, against its diagonal), or one that shows its walls.
    """
    if solid.kind != "closed":
        return solid.kind == "shell"
    return mean_thickness(solid) <= SOLID_THROUGHOUT_SHARE * diagonal(solid.points) or _shows_walls(solid, cavities)


def mean_thickness(solid: Solid) -> float:
    """Twice the volume over the surface (m): the thickness of a wall, a third of the diameter of a ball.

    Walls grown from sheets are left out where there are bodies beside them.
    """
    held, area = _bodies(solid)
    return 2.0 * held / area


def _bodies(solid: Solid) -> tuple[float, float]:
    """Volume (m3) and area (m2) of a solid without the walls grown from sheets, each of which has two sides."""
    full, area = volume(solid.points, solid.triangles), float(triangle_areas(solid.points[solid.triangles]).sum())
    if solid.walls is None or solid.wall_thickness_m is None:
        return full, area
    held, bare = full - solid.walls.volume_m3, area - 2.0 * solid.walls.volume_m3 / solid.wall_thickness_m
    return (held, bare) if held > 0.0 and bare > 0.0 else (full, area)


def _sheet_filling(solid: Solid, area: float, wall: Evidence[float] | None) -> FillFactors:
    low, high = wall_factors(wall)
    if wall is not None and wall.source != "default":
        return FillFactors(low, high, causes=wall_causes(wall))
    sheet = area * (solid.wall_thickness_m or LEAST_HOLLOW_WALL_M)
    try:
        full = volume(*convex_hull(solid.points)) / sheet
    except ValueError:
        full = 0.0
    filled = ("perhaps a filled body left open",) if full > high else ()
    return FillFactors(low, max(high, full), causes=(*wall_causes(wall), *filled))


def _shows_walls(solid: Solid, cavities: Sequence[Cavity]) -> bool:
    """A container or an inner shell, large against the hull, behind walls that are thin against the diagonal."""
    if mean_thickness(solid) > MODELLED_WALL_SHARE * diagonal(solid.points):
        return False
    hull = volume(*convex_hull(solid.points))
    if any(c.volume_m3 >= CAVITY_SHARE * hull and not c.through for c in cavities):
        return True
    points, triangles = weld_points(solid.points, solid.triangles)
    parts = components_of(points, triangles)
    return bool(-parts.volume[parts.inside_out].sum() >= CAVITY_SHARE * hull)


def _density_range(substance: Substance, filling: FillFactors) -> tuple[float, float]:
    value = substance.density_kgm3.value
    least, most = substance.density_kgm3.bounds or (value, value)
    if _is_declared(substance):
        least, most = least * (1.0 - STATED_VOLUME_TOLERANCE), most * (1.0 + STATED_VOLUME_TOLERANCE)
    if substance.may_be_hollow and filling.hollow < 1.0 and not _is_unknown(substance):
        least = min(least, filling.hollow * max(least, LEAST_WALL_KGM3))
    return least * filling.low, most * filling.high


def _is_declared(substance: Substance) -> bool:
    return substance.density_kgm3.source == "declared"


def _is_unknown(substance: Substance) -> bool:
    return substance.material.value == UNKNOWN and not _is_declared(substance)


def _unit_factors(unit: Evidence[float]) -> tuple[float, float]:
    low, high = unit.bounds or (unit.value, unit.value)
    return (low / unit.value) ** 3, (high / unit.value) ** 3


def _within_span(value: float, low: float, high: float, unit: tuple[float, float], causes: Sequence[str]) -> MassBounds:
    """Cut to the span by shrinking both sides in proportion; the unit gets what room the rest leaves."""
    truly = high * unit[1] / (low * unit[0])
    notes = [*causes, *(["unit provisional"] if unit[0] < 1.0 or unit[1] > 1.0 else [])]
    if high / low > MAX_SPAN:
        shrink = math.log(MAX_SPAN) / math.log(high / low)
        low, high = value * (low / value) ** shrink, value * (high / value) ** shrink
    elif truly > high / low:
        room = min(1.0, math.log(MAX_SPAN * low / high) / math.log(unit[1] / unit[0]))
        low, high = low * unit[0] ** room, high * unit[1] ** room
    return MassBounds(low, high, tuple(notes), truly)


def elementwise(matrix: FloatArray, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Bounds of each entry when the whole matrix is scaled by a factor between `low` and `high`."""
    both = np.stack([matrix * low, matrix * high])
    return both.min(axis=0), both.max(axis=0)
