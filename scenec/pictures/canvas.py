"""Canvas of scene pictures: axes in metres seen from above, the viewer at the lower edge; colours and drawing
helpers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, PathPatch
from matplotlib.path import Path
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from render.figure import figure
from schemas.arrays import FloatArray

INK, PAPER, SUPPORT, EDGE, CLEAR, WRONG, FREE = (
    "#1b1f24",
    "#ffffff",
    "#f1ece3",
    "#a89b86",
    "#8a929d",
    "#b3261e",
    "#1f7a4d",
)
THINGS = ("#7aa6d6", "#e0a458", "#8cbf88", "#c98bb9", "#d98880", "#76c2c0", "#b5a7d9", "#c9b458")
_LONG_IN = 8.5
_HALO = (patheffects.withStroke(linewidth=2.2, foreground="#ffffffd0"),)


def sheet(low: FloatArray, high: FloatArray, title: str, lines: int = 0) -> tuple[Figure, Axes]:
    """Empty figure and axes for x and y from `low` to `high` (2,), with a margin and room for `lines` of text below."""
    size = np.maximum(high - low, 1e-3)
    low, size = low - 0.06 * size.max(), size + 0.12 * size.max()
    width, height = _LONG_IN * np.minimum(size / size.max(), 1.0)
    sheet_figure = figure(float(max(width, 4.5)), float(max(height, 2.4)) + 0.7 + 0.17 * lines)
    axes = sheet_figure.subplots()
    axes.set_aspect("equal")
    axes.set_xlim(low[0], low[0] + size[0])
    axes.set_ylim(low[1], low[1] + size[1])
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    axes.spines[["top", "right"]].set_visible(False)
    return sheet_figure, axes


def area(axes: Axes, shape: BaseGeometry, *, order: float, **style: object) -> None:
    """Fill a polygon, several, or none, holes left open."""
    for polygon in polygons(shape):
        rings = [polygon.exterior, *polygon.interiors]
        path = Path.make_compound_path(*(Path(np.asarray(r.coords)[:, :2], closed=True) for r in rings))
        axes.add_patch(PathPatch(path, zorder=order, **style))


def polygons(shape: BaseGeometry) -> Sequence[Polygon]:
    """The polygons of a shape, without lines and points."""
    return [part for part in shapely.get_parts(shape) if isinstance(part, Polygon) and not part.is_empty]


def name(axes: Axes, at: FloatArray, text: str, *, order: float, size: float = 8.0, color: str = INK) -> None:
    """A readable name centred on a point."""
    axes.text(at[0], at[1], text, ha="center", va="center", fontsize=size, color=color, zorder=order).set_path_effects(
        list(_HALO)
    )


def arrow(
    axes: Axes, start: FloatArray, end: FloatArray, text: str, *, order: float, color: str = INK, bend: float = 0.12
) -> None:
    """A bent arrow between two points with a word at its middle."""
    axes.add_patch(
        FancyArrowPatch(
            tuple(start),
            tuple(end),
            arrowstyle="-|>",
            mutation_scale=11,
            shrinkA=4,
            shrinkB=4,
            linewidth=1.3,
            color=color,
            zorder=order,
            connectionstyle=f"arc3,rad={bend}",
        )
    )
    along = np.asarray(end) - start
    middle = (np.asarray(start) + end) / 2.0 + bend / 2.0 * np.array([along[1], -along[0]])
    name(axes, middle, text, order=order + 0.1, size=7.0, color=color)
