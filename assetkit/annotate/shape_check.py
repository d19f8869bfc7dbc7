"""Compares size, opening and form of an object with those of a category; confirms or weakens the category."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from assetkit.annotate.annotator import ObjectShape
from assetkit.taxonomy.tables import Category, Range
from geom.convex.hull import convex_hull, volume
from geom.convex.primitive_fits import fit_box
from schemas.arrays import FloatArray
from schemas.physics import Solid

# A size up to this factor outside the range is usual; beyond `IMPOSSIBLE` the category or the unit is wrong.
UNUSUAL, IMPOSSIBLE = 1.5, 3.0
# FITS removes this share of the doubt about the name; STRANGE and ANOTHER multiply the chance that it is right.
FITS, STRANGE, ANOTHER = 0.35, 0.6, 0.2
OPEN, NOT_OPEN, OTHER_FORM = 0.2, 0.5, 0.5
# An open vessel holds at least this share of its hull; a body that fills all but this share has no opening.
VESSEL_HOLLOW, FULL_HOLLOW = 0.3, 0.08
FILL_TOLERANCE = 0.06


class ShapeFinding(NamedTuple):
    """One comparison in words: `confirms` is the share of the doubt it removes, `remaining_chance` a factor."""

    text: str
    confirms: float = 0.0
    remaining_chance: float = 1.0


def shape_of(points: FloatArray, solid: Solid, *, metric: bool = True) -> ObjectShape:
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
        return ObjectShape(extents_m, None, None, metric)
    hollow = None
    if solid.kind == "closed":
        hollow = 1.0 - volume(solid.points, solid.triangles) / own_m3
    elif solid.kind == "shell":
        hollow = 1.0
    fill = hull_m3 / (edges[0] * edges[1] * edges[2]) if edges[0] > 0.0 else None
    return ObjectShape(extents_m, fill, hollow, metric)


def compare(category: Category, shape: ObjectShape) -> tuple[ShapeFinding, ...]:
    """The findings of size, opening and form; nothing where the table or the shape is silent."""
    return (*_size(category, shape), *_opening(category, shape), *_form(category, shape))


def misfit(category: Category, extents_m: Sequence[float]) -> float:
    """By which factor the worst of the sorted edges lies outside its range, 1 when all lie inside."""
    return max(_outside(edge, bounds) for edge, bounds in zip(extents_m, category.extents_m, strict=True))


def proportion_misfit(category: Category, extents_m: Sequence[float]) -> float:
    """As `misfit`, at the scale where it is least."""
    pairs = [(max(edge, 1e-9), bounds) for edge, bounds in zip(extents_m, category.extents_m, strict=True)]
    least, most = max(low / edge for edge, (low, _) in pairs), max(edge / high for edge, (_, high) in pairs)
    return max(math.sqrt(least * most), 1.0)


def _size(category: Category, shape: ObjectShape) -> Iterator[ShapeFinding]:
    if not shape.metric:
        factor = proportion_misfit(category, shape.extents_m)
        if factor > UNUSUAL:
            form = " : ".join(f"{edge / shape.extents_m[2]:.2g}" for edge in shape.extents_m)
            yield ShapeFinding(
                f"edges of {form} are no usual proportions",
                remaining_chance=ANOTHER if factor > IMPOSSIBLE else STRANGE,
            )
        return
    factor = misfit(category, shape.extents_m)
    size = " x ".join(f"{edge:.3g}" for edge in shape.extents_m) + " m"
    if factor <= 1.0:
        yield ShapeFinding(f"{size} is a usual size", confirms=FITS)
    elif factor > UNUSUAL:
        usual = " x ".join(f"{low:g}-{high:g}" for low, high in category.extents_m) + " m"
        remaining_chance = ANOTHER if factor > IMPOSSIBLE else STRANGE
        yield ShapeFinding(f"{size} is {factor:.2g} times outside of {usual}", remaining_chance=remaining_chance)


def _opening(category: Category, shape: ObjectShape) -> Iterator[ShapeFinding]:
    if category.opening != "yes" or shape.hollow is None:
        return
    if shape.hollow >= VESSEL_HOLLOW:
        yield ShapeFinding(f"{100 * shape.hollow:.0f} % of its hull is open", confirms=OPEN)
    elif shape.hollow < FULL_HOLLOW:
        yield ShapeFinding("it has no opening", remaining_chance=NOT_OPEN)


def _form(category: Category, shape: ObjectShape) -> Iterator[ShapeFinding]:
    if category.fill is None or shape.fill is None:
        return
    low, high = category.fill
    if not low - FILL_TOLERANCE <= shape.fill <= high + FILL_TOLERANCE:
        text = f"it fills {100 * shape.fill:.0f} % of its box, not {100 * low:.0f} to {100 * high:.0f} %"
        yield ShapeFinding(text, remaining_chance=OTHER_FORM)


def _outside(value: float, bounds: Range) -> float:
    low, high = bounds
    return max(low / max(value, 1e-9), value / high, 1.0)
