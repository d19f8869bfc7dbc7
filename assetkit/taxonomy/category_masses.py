"""Usual mass of the things of a category by volume, wall area or length, read from `usual_masses.csv` beside this file.

A row holds one kind of thing of a category, in the state in which it is usually scanned and simulated: packages `full`,
vessels and hollow goods `empty`, all else `solid`. Most ranges are computed: wall thickness times density of the wall,
density of contents times the share they fill; the others are trade sizes or single measured objects. They were written
down from general knowledge; no catalogue was opened.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cache
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

from assetkit.taxonomy.tables import Words, rows_of

Basis = Literal["hull", "wall", "length"]
State = Literal["full", "empty", "solid"]
RangeOrOne = Annotated[tuple[float, float], BeforeValidator(lambda cell: tuple((cell.split() * 2)[:2]))]


class CategoryMass(BaseModel):
    """One kind of thing of a category.

    words       names that distinguish this kind from the others of the category; () for one of the usual kinds.
    basis       what `range` is per: m3 of the convex `hull`, m2 of `wall` (one side), m3 of the cube of the `length`.
    range       where 95 % of such things lie (kg per unit of the basis); twice the same for a single object.
    weight      how often, against the other rows of the category, things are of this kind.
    own_row_of  the measured object that a row was written from, "" for others; tests leave theirs out.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    category: str
    words: Words
    state: State
    basis: Basis
    range: RangeOrOne
    weight: float
    own_row_of: str
    source: str


@cache
def category_masses() -> tuple[CategoryMass, ...]:
    """All rows, in the order of the table."""
    return tuple(CategoryMass.model_validate(row) for row in rows_of("usual_masses.csv"))


def masses_of_kind(category: str, names: Sequence[Collection[str]], without: str = "") -> tuple[CategoryMass, ...]:
    """The rows of the kinds that the first matching one of `names` (each as its words) mentions.

    When none matches, those of the usual kinds of the category. `without` names a measured object: its row is left out.
    """
    rows = [r for r in category_masses() if r.category == category and (not without or r.own_row_of != without)]
    matching = (tuple(row for row in rows if not set(row.words).isdisjoint(words)) for words in names)
    return next(filter(None, matching), tuple(row for row in rows if not row.words))
