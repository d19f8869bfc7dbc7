"""Jittered grid: places unrelated things that have room to turn evenly over their place.

Each gets a point of a square grid with room for its largest radius, moved randomly within the rest of the pitch. Shelf
packing would place the same things in tight rows and leave the rest of the place empty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Placement
from scenec.solve.model import Site, SolverModel
from scenec.solve.placed import Placed
from scenec.solve.planar import ROUND_OUT
from scenec.solve.shelf import free_area, item_of
from scenec.solve.streams import stream

PITCHES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)  # of that at which a square grid has as many points as there are things


def spread_grid(
    model: SolverModel, names: Sequence[str], standing: Mapping[str, Placed], seed: int
) -> dict[str, Placement] | None:
    """Placements (in A) for all of `names`, all of one place; None where a relation involves one of them, ranges
    differ, or circles around their origins do not fit on a grid."""
    things = [model.things[name] for name in names]
    items = [item_of(model, thing) for thing in things]
    ranges = {(thing.domain.x_m, thing.domain.y_m) for thing in things}
    bound = any(model.rules_of.get(name) or model.limits.get(name) for name in names)
    if bound or len(ranges) > 1 or model.problem.reach is not None:
        return None
    chosen = [(item.stance, item.yaw_rad) for item in items if item is not None]
    if len(chosen) < len(names):
        return None
    shapes = [model.shapes[name][stance] for name, (stance, _) in zip(names, chosen, strict=True)]
    radius_m = max(shape.radius_m for shape in shapes) * ROUND_OUT
    site, ((x_m, y_m),) = model.site(things[0]), ranges
    mates = [placed for placed in standing.values() if placed.parent == site.parent]
    area = free_area(model, site, mates, max(shape.height_m for shape in shapes))
    region = _within(area.buffer(-radius_m), site, x_m, y_m)
    rng = stream(seed, "grid", *names)
    points = _points(region, len(names), 2.0 * radius_m + model.problem.clearance_m, rng)
    if points is None:
        return None
    ox, oy = (float(v) for v in site.origin_P_m[:2])
    return {
        name: Placement(x - ox, y - oy, yaw, stance)
        for name, (x, y), (stance, yaw) in zip(names, points.tolist(), chosen, strict=True)
    }


def _within(region: BaseGeometry, site: Site, x_m: tuple[float, float], y_m: tuple[float, float]) -> BaseGeometry:
    """The part of a region (in P) inside ranges of x and y in A."""
    if region.is_empty:
        return region
    ox, oy = (float(v) for v in site.origin_P_m[:2])
    x0, y0, x1, y1 = region.bounds
    low = max(x0, x_m[0] + ox), max(y0, y_m[0] + oy)
    high = min(x1, x_m[1] + ox), min(y1, y_m[1] + oy)
    if low[0] >= high[0] or low[1] >= high[1]:
        return shapely.Polygon()
    return region.intersection(shapely.box(*low, *high))


def _points(region: BaseGeometry, count: int, least_m: float, rng: np.random.Generator) -> np.ndarray | None:
    """(count, 2) points of a region at least `least_m` apart, on a jittered square grid; None where it has too few."""
    if region.area <= 0.0:
        return None
    x0, y0, x1, y1 = region.bounds
    for share in PITCHES:
        pitch = max(share * sqrt(region.area / count), least_m)
        axes = [_axis(low, high, pitch) for low, high in ((x0, x1), (y0, y1))]
        grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        moved = grid + rng.uniform(-0.5, 0.5, grid.shape) * (pitch - least_m)
        inside = shapely.contains_xy(region, moved[:, 0], moved[:, 1])
        if inside.sum() >= count:
            return moved[rng.permutation(np.flatnonzero(inside))[:count]]
        if pitch == least_m:
            return None
    return None


def _axis(low: float, high: float, pitch: float) -> np.ndarray:
    """Coordinates at a pitch, as many as fit, centred in the interval."""
    steps = int((high - low) / pitch)
    return (low + high - steps * pitch) / 2.0 + pitch * np.arange(steps + 1)
