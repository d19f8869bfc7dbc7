"""What things of a category weigh for their size, read from `usual_masses.csv` beside this file.

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


class UsualMass(BaseModel):
    """One kind of thing of a category.

    words       names that tell this kind from the others of the category; () when it is one of the usual kinds.
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
def usual_masses() -> tuple[UsualMass, ...]:
    """All rows, in the order of the table."""
    return tuple(UsualMass.model_validate(row) for row in rows_of("usual_masses.csv"))


def kinds_of(category: str, names: Sequence[Collection[str]], without: str = "") -> tuple[UsualMass, ...]:
    """The rows of the kinds that the first telling one of `names` (each as its words) speaks of.

    When none does, those of the usual kinds of the category. `without` leaves out the row written from that object.
    """
    rows = [r for r in usual_masses() if r.category == category and (not without or r.own_row_of != without)]
    told = (tuple(row for row in rows if not set(row.words).isdisjoint(words)) for words in names)
    return next(filter(None, told), tuple(row for row in rows if not row.words))
