"""Usual materials of things and their parts, and the surface appearance of materials, from the tables beside this file.

`usual_materials.csv`: of 100 things of a category, or parts called so, how many are of each class of `materials.csv`
(parts of `any` category by name). `looks.csv`: how usual each class is among household things, and the
appearance of its surfaces: shares of tones, of smooth, satin and rough ones, of metallic values in authored maps, of
see-through ones. Both were written down from general knowledge; nothing was fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Annotated

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict

from assetkit.taxonomy.tables import Words, rows_of
from assetkit.taxonomy.words import singulars
from schemas.arrays import FloatArray

ANY = "any"
_weighted = BeforeValidator(
    lambda cell: {name: float(weight) for name, weight in (entry.split() for entry in cell.split(";"))}
)


class CategoryMaterials(BaseModel):
    """One row: a category, its part names (() for the thing as a whole), and classes with their weights."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    category: str
    parts: Words
    materials: Annotated[dict[str, float], _weighted]


@cache
def appearance_table() -> dict[str, dict[str, float]]:
    """Class -> column -> share; `usual` is the weight among household things."""
    return {r["material"]: {k: float(v) for k, v in r.items() if k != "material"} for r in rows_of("looks.csv")}


@cache
def class_names() -> tuple[str, ...]:
    """Names of the classes that can be distinguished, in the order of all arrays."""
    return tuple(appearance_table())


@cache
def category_materials() -> tuple[CategoryMaterials, ...]:
    """All rows, in the order of the table."""
    return tuple(CategoryMaterials.model_validate(row) for row in rows_of("usual_materials.csv"))


def household_prior() -> FloatArray:
    """(k,) prior probabilities of the classes of any household thing."""
    return _normalised({name: row["usual"] for name, row in appearance_table().items()})


def material_prior(category: str, label: str, words: Sequence[str]) -> tuple[FloatArray | None, str]:
    """(k,) prior probabilities for the part `label` ("" for the whole) of a `category`, and the matching row in words.

    `words` are those of the part's name in the source, in order; the last known one counts, where the category has no
    row for the part: motor mounts are mounts.
    """
    rows = {
        row.category: [r for r in category_materials() if r.category == row.category] for row in category_materials()
    }
    category_rows = rows.get(category, []) if category != ANY else []
    for row in category_rows:
        if label and label in row.parts:
            return _normalised(row.materials), f"{label} of a {category}"
    called = {part: row for row in rows[ANY] for part in row.parts}
    part_words = (form for word in (label, *reversed(words)) for form in (word, *singulars(word)) if form in called)
    if (part_word := next(part_words, "")) != "":
        return _normalised(called[part_word].materials), f"a {part_word}"
    for row in category_rows:
        if not row.parts:
            return _normalised(row.materials), category
    return None, ""


def _normalised(weights: dict[str, float]) -> FloatArray:
    values = np.array([weights.get(name, 0.0) for name in class_names()])
    return values / values.sum()
