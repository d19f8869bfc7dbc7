"""Where a long thing changes its section: blade and handle, bowl and handle, shaft and grip, cap or neck, stem.

The section is followed along the principal axis of the surface, so a turned or scaled object has the same regions.
Ratios are those of things that hands use; none is a length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.features.regions import Faces, Region, Role
from geom.mesh.surface_distance import sample_surface
from schemas.model import FloatArray

_SAMPLES, _SLICES = 8000, 48
_LONG = 2.0  # times as long as wide: what is shorter has no direction of its own
_END = 0.1  # of the length: a working end or a grip is no shorter
_CONTRAST = np.log(1.5)  # The two sides of a split differ in width or thickness by half or more ...
_EXPLAINED = 0.6  # ... and the step, not a taper, explains most of how the section varies; a wedge leaves a quarter.
_LONGEST_NECK = 0.45  # of the length of a bottle; that of a wine bottle is a third
_STEM = 0.5  # times as wide as what it joins: a stem is held between two fingers
_LONGEST_STEM = 0.75


class Profile(NamedTuple):
    """The section of a surface along its axis, in slices of equal length; lengths in units of the surface.

    along      (m,) where the middle of each triangle lies, 0..1.     long   length over the larger width.
    width      (s,) larger extent across, in the second principal axis.
    thickness  (s,) smaller extent across, in the third.
    """

    along: FloatArray
    long: float
    width: FloatArray
    thickness: FloatArray


def profile(surface: Faces) -> Profile | None:
    """The section along the axis in which the surface varies most; None when it has no length or is a line."""
    axes = _principal(surface)
    points = sample_surface(surface.points, surface.triangles, _SAMPLES, 0)[0] @ axes.T
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    if size[0] <= 0.0 or size[1] <= 0.0:
        return None
    slices = np.clip(((points[:, 0] - low[0]) / size[0] * _SLICES).astype(np.int64), 0, _SLICES - 1)
    least, most = np.full((_SLICES, 2), np.inf), np.full((_SLICES, 2), -np.inf)
    np.minimum.at(least, slices, points[:, 1:])
    np.maximum.at(most, slices, points[:, 1:])
    across = np.maximum(most - least, 1e-3 * size[1])  # A slice that no sample met, or a sheet on edge.
    along = np.clip((surface.middle @ axes[0] - low[0]) / size[0], 0.0, 1.0)
    return Profile(along, float(size[0] / size[1:].max()), across[:, 0], across[:, 1])


def broad_regions(surface: Faces) -> tuple[Region, ...]:
    """The `broad` and the `slim` end of a long thing: a bowl, a head, and the handle."""
    section = profile(surface)
    return _split(section, section.width, ("broad", "slim")) if section else ()


def stout_regions(surface: Faces) -> tuple[Region, ...]:
    """The `stout` and the `thin` end of a long thing: a handle and a blade."""
    section = profile(surface)
    return _split(section, section.thickness, ("stout", "thin")) if section else ()


def _split(section: Profile, values: FloatArray, roles: tuple[Role, Role]) -> tuple[Region, ...]:
    cut = _step(np.log(values)) if section.long >= _LONG else None
    if cut is None:
        return ()
    larger = section.along < cut / _SLICES
    if np.log(values[:cut]).mean() < np.log(values[cut:]).mean():
        larger = ~larger
    return Region(roles[0], larger), Region(roles[1], ~larger)


def end_regions(surface: Faces) -> tuple[Region, ...]:
    """The end of a bottle that is narrower than the rest, equally wide all along, and ends in a step.

    A `neck` when it is longer than wide, else a `cap`: closures are flat, since a hand turns them.
    """
    section = profile(surface)
    if section is None:
        return ()
    width = np.sqrt(section.width * section.thickness)
    found: list[Region] = []
    for values, place in ((width, section.along), (width[::-1], 1.0 - section.along)):
        slices = _even_end(values)
        if slices:
            length = slices / _SLICES * section.long * max(section.width.max(), section.thickness.max())
            across = float(np.median(values[1:slices]))
            found.append(Region("neck" if length > 1.5 * across else "stopper", place < slices / _SLICES))
    return tuple(found) if len(found) == 1 else ()


def stem_regions(surface: Faces) -> tuple[Region, ...]:
    """A `stem` between two wider ends, the longer one `over` it, the flat one its `foot`: a wine glass."""
    section = profile(surface)
    if section is None:
        return ()
    width = np.sqrt(section.width * section.thickness)
    slim = width < _STEM * width.max()
    runs = [run for run in np.split(np.arange(_SLICES), np.flatnonzero(np.diff(slim.astype(int))) + 1) if slim[run[0]]]
    inner = [run for run in runs if run[0] > 0 and run[-1] < _SLICES - 1]
    if len(inner) != 1 or not _END < len(inner[0]) / _SLICES < _LONGEST_STEM:
        return ()
    along, ends = section.along, (inner[0][0] / _SLICES, 1.0 - (inner[0][-1] + 1) / _SLICES)
    if ends[0] > ends[1]:
        along, ends = 1.0 - along, ends[::-1]
    if ends[0] > 0.5 * ends[1]:  # Two ends alike: a dumb-bell, an hourglass.
        return ()
    foot, over = along < ends[0], along >= 1.0 - ends[1]
    return Region("stem", ~foot & ~over), Region("over", over), Region("foot", foot)


def _principal(surface: Faces) -> FloatArray:
    """(3, 3) principal axes of the surface in rows, the one along which it varies most first; signs mean nothing."""
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
