"""A search request as data: one criterion per property that the assets should have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Field = Literal[
    "category", "family", "role", "outcome", "colour", "material", "size_m", "height_m", "mass_kg",
    "anchor", "task", "part", "text",
]  # fmt: skip


@dataclass(frozen=True)
class Criterion:
    """One property that an asset should have.

    words      words of the request, or the flag, that were read as this criterion.
    values     any of these matches, in the field's vocabulary.
    low, high  limits of a figure in the field's unit.
    reading    what the words were taken for.
    is_kind    whether it names the kind of object: an asset that does not match it is no hit.
    optional   an asset that does not match it ranks lower and is still a hit.
    stated     only a value that the record states counts, no mere hypothesis (flags).
    negated    the property must be absent: "not red", "without a handle".
    """

    words: str
    field: Field
    values: tuple[str, ...] = ()
    low: float = 0.0
    high: float = float("inf")
    reading: str = ""
    is_kind: bool = False
    optional: bool = False
    stated: bool = False
    negated: bool = False
