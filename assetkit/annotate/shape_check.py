"""Whether a thing of this size and form can be of a category."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from assetkit.annotate.annotator import Shape
from assetkit.taxonomy.tables import Category, Range
from geom.convex.hull import convex_hull, volume
from geom.convex.primitive_fits import fit_box
from schemas.model import FloatArray
from schemas.physics import Solid

# A thing up to this much beyond its category's range is unusual; beyond `IMPOSSIBLE` it is another one, or the unit is.
UNUSUAL, IMPOSSIBLE = 1.5, 3.0
# How these change the chance that the name is right; above 1 means: that share of the doubt goes away.
FITS, STRANGE, ANOTHER = 0.35, 0.6, 0.2
OPEN, NOT_OPEN, OTHER_FORM = 0.2, 0.5, 0.5
# An open vessel holds at least this share of its hull; a body that fills all but this share has no opening.
VESSEL_HOLLOW, FULL_HOLLOW = 0.3, 0.08
FILL_TOLERANCE = 0.06


class Finding(NamedTuple):
    """One comparison: what was found, by how much it confirms (> 0, share of the doubt) or what chance it leaves."""

    text: str
    confirms: float = 0.0
    leaves: float = 1.0


def shape_of(points: FloatArray, solid: Solid, *, metric: bool = True) -> Shape:
    """The shape of an object from its visible points (n, 3) and its physical surface, both in metres; in unknown units
    when not `metric`.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    box = fit_box(points)
    edges = sorted(box.size_m if box is not None else (float(e) for e in high - low))
    extents_m = edges[0], edges[1], edges[2]
    try:
        hull_m3 = volume(*convex_hull(points))
        own_m3 = volume(*convex_hull(solid.points))
    except ValueError:  # Flat.
        return Shape(extents_m, None, None, metric)
    hollow = None
    if solid.kind == "closed":
        hollow = 1.0 - volume(solid.points, solid.triangles) / own_m3
    elif solid.kind == "shell":
        hollow = 1.0
    fill = hull_m3 / (edges[0] * edges[1] * edges[2]) if edges[0] > 0.0 else None
    return Shape(extents_m, fill, hollow, metric)


def compare(category: Category, shape: Shape) -> tuple[Finding, ...]:
    """The findings of size, opening and form; nothing where the table or the shape is silent."""
    return (*_size(category, shape), *_opening(category, shape), *_form(category, shape))


def misfit(category: Category, extents_m: Sequence[float]) -> float:
    """By which factor the worst of the sorted edges lies outside its range, 1 when all lie inside."""
    return max(_outside(edge, bounds) for edge, bounds in zip(extents_m, category.extents_m, strict=True))


def misproportion(category: Category, extents_m: Sequence[float]) -> float:
    """As `misfit`, at the scale where it is least."""
    pairs = [(max(edge, 1e-9), bounds) for edge, bounds in zip(extents_m, category.extents_m, strict=True)]
    least, most = max(low / edge for edge, (low, _) in pairs), max(edge / high for edge, (_, high) in pairs)
    return max(math.sqrt(least * most), 1.0)


def _size(category: Category, shape: Shape) -> Iterator[Finding]:
    if not shape.metric:
        factor = misproportion(category, shape.extents_m)
        if factor > UNUSUAL:
            form = " : ".join(f"{edge / shape.extents_m[2]:.2g}" for edge in shape.extents_m)
            yield Finding(
                f"edges of {form} are no usual proportions", leaves=ANOTHER if factor > IMPOSSIBLE else STRANGE
            )
        return
    factor = misfit(category, shape.extents_m)
    size = " x ".join(f"{edge:.3g}" for edge in shape.extents_m) + " m"
    if factor <= 1.0:
        yield Finding(f"{size} is a usual size", confirms=FITS)
    elif factor > UNUSUAL:
        usual = " x ".join(f"{low:g}-{high:g}" for low, high in category.extents_m) + " m"
        leaves = ANOTHER if factor > IMPOSSIBLE else STRANGE
        yield Finding(f"{size} is {factor:.2g} times outside of {usual}", leaves=leaves)


def _opening(category: Category, shape: Shape) -> Iterator[Finding]:
    if category.opening != "yes" or shape.hollow is None:
        return
    if shape.hollow >= VESSEL_HOLLOW:
        yield Finding(f"{100 * shape.hollow:.0f} % of its hull is open", confirms=OPEN)
    elif shape.hollow < FULL_HOLLOW:
        yield Finding("it has no opening", leaves=NOT_OPEN)


def _form(category: Category, shape: Shape) -> Iterator[Finding]:
    if category.fill is None or shape.fill is None:
        return
    low, high = category.fill
    if not low - FILL_TOLERANCE <= shape.fill <= high + FILL_TOLERANCE:
        said = f"it fills {100 * shape.fill:.0f} % of its box, not {100 * low:.0f} to {100 * high:.0f} %"
        yield Finding(said, leaves=OTHER_FORM)


def _outside(value: float, bounds: Range) -> float:
    low, high = bounds
    return max(low / max(value, 1e-9), value / high, 1.0)
