"""A plan seen from above: the cells of some cases, and where things were drawn."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon as Patch
from matplotlib.patches import Rectangle

from render.figure import png
from runtime_plan import Plan, sample
from runtime_plan.tables import MICRO
from schemas.scene.runtime_plan import PlanCombination, PlanPlace, PlanPool, PlanThing

_COLOURS = (
    "#4c78a8",
    "#f58518",
    "#54a24b",
    "#e45756",
    "#72b7b2",
    "#b279a2",
    "#ff9da6",
    "#9d755d",
    "#eeca3b",
    "#8c8c8c",
)
_CASES, _DRAWN_SAMPLES, _MOST_LEGEND_NAMES = 4, 400, 12


def picture(plan: Plan, seed: int = 0) -> bytes:
    """PNG of the three largest pools of the first combination, a row for each of the places that their things are on.

    Left the cells of the cases with the greatest shares; right the asset origins of 400 samples; in A of the place.
    """
    one = plan.document.combinations[0]
    pools = sorted(one.pools, key=lambda pool: (-len(pool.things), -len(pool.cases)))[:3]
    homes = {thing.id: thing.place for thing in one.things}
    rows = [(pool, home) for pool in pools for home in sorted({homes[name] for name in pool.things})]
    sheet = Figure(figsize=(3.0 * (_CASES + 1), 2.6 * len(rows)), layout="constrained")
    grid = sheet.subplots(len(rows), _CASES + 1, squeeze=False)
    for row, (pool, home) in zip(grid, rows, strict=True):
        owner, place = one.places[home]
        cases = sorted(pool.cases, key=lambda case: -case.weight)[:_CASES]
        for axes in row:
            _outline(axes, place)
        for axes, case in zip(row, cases, strict=False):
            for k, (low_x, high_x, low_y, high_y) in enumerate(case.cells_um):
                if homes[pool.things[k]] != home:
                    continue
                corner = (low_x * MICRO, low_y * MICRO)
                size = ((high_x - low_x) * MICRO, (high_y - low_y) * MICRO)
                colour = _COLOURS[k % len(_COLOURS)]
                axes.add_patch(Rectangle(corner, *size, facecolor=colour, edgecolor=colour, alpha=0.45))
                if len(pool.things) <= _MOST_LEGEND_NAMES:
                    middle = (corner[0] + size[0] / 2, corner[1] + size[1] / 2)
                    axes.text(*middle, pool.things[k], ha="center", va="center", fontsize=6)
            axes.set_title(f"{case.family.replace('_', ' ')}, on {owner}", fontsize=8)
        _origins(row[-1], plan, one, pool, home, seed)
    return png(sheet)


def _thing(one: PlanCombination, name: str) -> PlanThing:
    return next(thing for thing in one.things if thing.id == name)


def _outline(axes: Axes, place: PlanPlace) -> None:
    polygon = place.polygon or (place.layers[0].polygon if place.layers else None)
    if polygon is not None:
        axes.add_patch(Patch(np.array(polygon.outline_m), facecolor="#f4f1ea", edgecolor="#999999"))
        for hole in polygon.holes_m:
            axes.add_patch(Patch(np.array(hole), facecolor="white", edgecolor="#999999"))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()


def _origins(axes: Axes, plan: Plan, one: PlanCombination, pool: PlanPool, home: int, seed: int) -> None:
    """Where the asset origins of samples of the combination lie, in A of one place."""
    drawn = sample(plan, _DRAWN_SAMPLES, seed)
    rows = drawn.combination == 0
    for k, name in enumerate(pool.things):
        thing = _thing(one, name)
        if thing.place != home:
            continue
        column, origin = drawn.names.index(name), np.array(one.places[thing.place][1].origin_m[:2])
        at = drawn.position_m[rows, column, :2]
        if thing.parent in drawn.names:
            owner = drawn.names.index(thing.parent)
            at, quat = at - drawn.position_m[rows, owner, :2], drawn.quat_wxyz[rows, owner]
            yaw = 2.0 * np.arctan2(quat[:, 3], quat[:, 0])
        else:
            X_WB = np.array(one.X_WB)
            at, yaw = at - X_WB[:2, 3], np.full(len(at), np.arctan2(X_WB[1, 0], X_WB[0, 0]))
        c, s = np.cos(yaw), np.sin(yaw)
        x, y = c * at[:, 0] + s * at[:, 1] - origin[0], c * at[:, 1] - s * at[:, 0] - origin[1]
        axes.scatter(x, y, s=3, color=_COLOURS[k % len(_COLOURS)], linewidths=0)
    axes.set_title(f"origins of {int(rows.sum())} samples", fontsize=8)
