"""Regions of an elongated surface at which its cross-section changes: blade and handle, bowl, neck, cap, stem.

The section is sampled along the principal axis of the surface, so a rotated or scaled object has the same regions.
Thresholds are ratios, chosen for hand-held objects; none is a length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.features.regions import FaceGeometry, Role, SurfaceRegion
from geom.mesh.surface_distance import sample_surface
from schemas.arrays import FloatArray

_AXIAL_SAMPLES, _AXIAL_SLICES = 8000, 48
_LONG = 2.0  # times as long as wide: shorter objects have no clear axis
_END = 0.1  # of the length: a working end or a grip is no shorter
_CONTRAST = np.log(1.5)  # The two sides of a split differ in width or thickness by half or more ...
_EXPLAINED = 0.6  # ... and the step, not a taper, explains most of how the section varies; a wedge leaves a quarter.
_LONGEST_NECK = 0.45  # of the length of a bottle; that of a wine bottle is a third
_STEM = 0.5  # times as wide as what it joins: a stem is held between two fingers
_LONGEST_STEM = 0.75


class SectionProfile(NamedTuple):
    """The section of a surface along its axis, in slices of equal length; lengths in units of the surface.

    along      (m,) position of each triangle's middle, 0..1.         long   length over the larger width.
    width      (s,) larger extent across, in the second principal axis.
    thickness  (s,) smaller extent across, in the third.
    """

    along: FloatArray
    long: float
    width: FloatArray
    thickness: FloatArray


def section_profile(surface: FaceGeometry) -> SectionProfile | None:
    """The section along the axis of largest variance; None when the surface has no length or is a line."""
    axes = _principal(surface)
    points = sample_surface(surface.points, surface.triangles, _AXIAL_SAMPLES, 0)[0] @ axes.T
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    if size[0] <= 0.0 or size[1] <= 0.0:
        return None
    slices = np.clip(((points[:, 0] - low[0]) / size[0] * _AXIAL_SLICES).astype(np.int64), 0, _AXIAL_SLICES - 1)
    least, most = np.full((_AXIAL_SLICES, 2), np.inf), np.full((_AXIAL_SLICES, 2), -np.inf)
    np.minimum.at(least, slices, points[:, 1:])
    np.maximum.at(most, slices, points[:, 1:])
    across = np.maximum(most - least, 1e-3 * size[1])  # A slice that no sample met, or a sheet on edge.
    along = np.clip((surface.middle @ axes[0] - low[0]) / size[0], 0.0, 1.0)
    return SectionProfile(along, float(size[0] / size[1:].max()), across[:, 0], across[:, 1])


def regions_by_width(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """The `broad` and the `slim` end of an elongated object: a bowl or a head, and the handle."""
    section = section_profile(surface)
    return _split(section, section.width, ("broad", "slim")) if section else ()


def regions_by_thickness(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """The `stout` and the `thin` end of an elongated object: a handle and a blade."""
    section = section_profile(surface)
    return _split(section, section.thickness, ("stout", "thin")) if section else ()


def _split(section: SectionProfile, values: FloatArray, roles: tuple[Role, Role]) -> tuple[SurfaceRegion, ...]:
    cut = _step(np.log(values)) if section.long >= _LONG else None
    if cut is None:
        return ()
    larger = section.along < cut / _AXIAL_SLICES
    if np.log(values[:cut]).mean() < np.log(values[cut:]).mean():
        larger = ~larger
    return SurfaceRegion(roles[0], larger), SurfaceRegion(roles[1], ~larger)


def neck_regions(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """The end of a bottle that is narrower than the rest, of even width, and bounded by a step.

    Its role is `neck` when it is longer than wide, else `stopper`: closures are flat, since a hand turns them.
    """
    section = section_profile(surface)
    if section is None:
        return ()
    width = np.sqrt(section.width * section.thickness)
    ends: list[SurfaceRegion] = []
    for values, place in ((width, section.along), (width[::-1], 1.0 - section.along)):
        slices = _even_end(values)
        if slices:
            length = slices / _AXIAL_SLICES * section.long * max(section.width.max(), section.thickness.max())
            across = float(np.median(values[1:slices]))
            ends.append(SurfaceRegion("neck" if length > 1.5 * across else "stopper", place < slices / _AXIAL_SLICES))
    return tuple(ends) if len(ends) == 1 else ()


def stem_regions(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """A `stem` between two wider ends, the longer one `over` it, the flat one its `foot`: a wine glass."""
    section = section_profile(surface)
    if section is None:
        return ()
    width = np.sqrt(section.width * section.thickness)
    slim = width < _STEM * width.max()
    runs = [
        run for run in np.split(np.arange(_AXIAL_SLICES), np.flatnonzero(np.diff(slim.astype(int))) + 1) if slim[run[0]]
    ]
    inner = [run for run in runs if run[0] > 0 and run[-1] < _AXIAL_SLICES - 1]
    if len(inner) != 1 or not _END < len(inner[0]) / _AXIAL_SLICES < _LONGEST_STEM:
        return ()
    along, ends = section.along, (inner[0][0] / _AXIAL_SLICES, 1.0 - (inner[0][-1] + 1) / _AXIAL_SLICES)
    if ends[0] > ends[1]:
        along, ends = 1.0 - along, ends[::-1]
    if ends[0] > 0.5 * ends[1]:  # Two ends alike: a dumb-bell, an hourglass.
        return ()
    foot, over = along < ends[0], along >= 1.0 - ends[1]
    return SurfaceRegion("stem", ~foot & ~over), SurfaceRegion("over", over), SurfaceRegion("foot", foot)


def _principal(surface: FaceGeometry) -> FloatArray:
    """(3, 3) principal axes of the surface in rows, by falling variance; signs are arbitrary."""
    corners = surface.points[surface.triangles]
    weight = surface.area / max(float(surface.area.sum()), np.finfo(float).tiny)
    centre = weight @ surface.middle
    away = corners - centre
    # Exact second moment of triangles: nine times that of the middle and once that of each corner, over twelve.
    moment = sum(np.einsum("m,mi,mj->ij", weight, away[:, k], away[:, k]) for k in range(3))
    moment = moment + 9.0 * np.einsum("m,mi,mj->ij", weight, surface.middle - centre, surface.middle - centre)
    return np.linalg.eigh(moment)[1].T[::-1]


def _step(values: FloatArray) -> int | None:
    """Number of slices before the step that splits `values` (s,) best into two even ends; None without one."""
    least = max(int(_END * len(values)), 2)
    inner = values[1:-1]  # The outermost slices are rounded off.
    whole = float(((inner - inner.mean()) ** 2).sum())
    best: tuple[float, int] | None = None
    for cut in range(least, len(values) - least + 1):
        sides = values[1:cut], values[cut:-1]
        spread = float(sum(((s - s.mean()) ** 2).sum() for s in sides))
        if best is None or spread < best[0]:
            best = spread, cut
    if best is None or whole <= 0.0:
        return None
    spread, cut = best
    differs = abs(float(values[1:cut].mean() - values[cut:-1].mean())) >= _CONTRAST
    return cut if differs and 1.0 - spread / whole >= _EXPLAINED else None


def _even_end(width: FloatArray) -> int:
    """Number of slices at the beginning that are equally wide and end in a step; 0 if there is no such end."""
    first = float(np.median(width[1:4]))
    if not 0.0 < first < 0.8 * width.max():
        return 0
    even = np.abs(width / first - 1.0) < 0.12
    even[0] = True  # Rounded off.
    length = int(np.argmin(even)) if not even.all() else len(width)
    stepped = abs(float(width[min(length + 2, len(width) - 1)]) / first - 1.0) > 0.15
    return length if 3 <= length <= _LONGEST_NECK * len(width) and stepped else 0
