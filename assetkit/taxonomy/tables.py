"""Categories, families and interaction groups, read from the tables beside this file.

`categories.csv` holds 44 kinds of rigid tabletop things in 10 families and, with scope `surrounding`, the furniture,
appliances and fixtures around them; `interaction_groups.csv` the 9 ways in which articulated things move. Sizes and
masses carry their source and how sure it is. `other_things.csv` names what is outside the vocabulary, so that a word
in it is not taken for a category; `fillers.csv` words without information about the category. `size_anchors.csv` are
things of known size.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from functools import cache
from importlib import resources
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

from schemas.asset import Role

# Cells of the tables: lists are separated by `;`, ranges by a blank.
_listed = BeforeValidator(lambda cell: tuple(cell.split(";")) if cell else ())
Words = Annotated[tuple[str, ...], _listed]
Roles = Annotated[tuple[Role, ...], _listed]
Range = Annotated[tuple[float, float], BeforeValidator(str.split)]
MaybeRange = Annotated[tuple[float, float] | None, BeforeValidator(lambda cell: cell.split() or None)]
Scope = Literal["tabletop", "surrounding"]
OBJECT_QCODE = "Q488383"  # Wikidata "object": true of every asset, claims nothing more.


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Family(_Row):
    """Things of one domain; `qcode` is true of all of them."""

    id: str
    scope: Scope
    title: str
    qcode: str


class InteractionGroup(_Row):
    """Articulated things that move alike.

    joints  joint types, the usual one first.     motion  about or along what.
    words   how parts that move so are called.    travel  usual range, in words.
    """

    id: str
    title: str
    joints: Words
    motion: str
    parts: Words
    roles: Roles
    words: Words
    travel: str


class Category(_Row):
    """One kind of thing.

    aliases        names that mean it.      weak_aliases  names that mean it among other things ("plate", "mouse").
    qcode_level    whether the Wikidata class is that of the `leaf`, of its `family`, or of any `object`.
    roles, parts   what it may be in a task, and what its parts are called; the first role is the usual one.
    small_m, middle_m, large_m, mass_kg   least and greatest plausible value; edges of the bounding box, sorted.
    sureness       `published`: measured objects or standards; `catalogue`: trade sizes; `estimate`: neither.
    stands         reference pose: `opening` up, on its `base`, `flat` on its widest side, or `any`.
    symmetry       `full` like a ball, `axial` about the upright axis (long axis of what lies flat), `mirror` or `none`.
    opening        whether things can be put in from outside: `yes`, `no`, `maybe` (closed bottles, scanned cans).
    fill           share of its bounding box that its convex hull takes, or None where that is no evidence.
    group          how it moves when it is articulated, or "".
    """

    id: str
    scope: Scope
    family: str
    aliases: Words
    weak_aliases: Words
    qcode: str
    qcode_level: Literal["leaf", "family", "object"]
    roles: Roles
    parts: Words
    small_m: Range
    middle_m: Range
    large_m: Range
    mass_kg: Range
    sureness: Literal["published", "catalogue", "estimate"]
    source: str
    stands: Literal["opening", "base", "flat", "any"]
    symmetry: Literal["full", "axial", "mirror", "none"]
    materials: Words
    opening: Literal["yes", "no", "maybe"]
    fill: MaybeRange
    group: str

    @property
    def extents_m(self) -> tuple[Range, Range, Range]:
        """Ranges of the sorted edges of the bounding box, shortest first."""
        return self.small_m, self.middle_m, self.large_m


@cache
def categories() -> dict[str, Category]:
    """All categories by id, in the order of the table."""
    return {row["id"]: Category.model_validate(row) for row in rows_of("categories.csv")}


class SizeAnchor(_Row):
    """One thing of known size: sorted edges of its box in millimetres, and how sure they are, as for a category."""

    category: str
    name: str
    edges_mm: Annotated[tuple[float, float, float], BeforeValidator(str.split)]
    sureness: Literal["published", "catalogue", "estimate"]
    source: str


@cache
def size_anchors() -> tuple[SizeAnchor, ...]:
    """Things of known size, in the order of the table."""
    return tuple(SizeAnchor.model_validate(row) for row in rows_of("size_anchors.csv"))


@cache
def families() -> dict[str, Family]:
    """All families by id."""
    return {row["id"]: Family.model_validate(row) for row in rows_of("families.csv")}


@cache
def interaction_groups() -> dict[str, InteractionGroup]:
    """All interaction groups by id."""
    return {row["id"]: InteractionGroup.model_validate(row) for row in rows_of("interaction_groups.csv")}


@cache
def other_motions() -> frozenset[str]:
    """Names of moved parts that belong to no interaction group: limbs of robots, wheels, parts of machines."""
    return frozenset(word for row in rows_of("other_motions.csv") for word in row["words"].split(";"))


@cache
def other_things() -> tuple[str, ...]:
    """Names of things outside the vocabulary, and of parts and holders of things in it."""
    return tuple(name for row in rows_of("other_things.csv") for name in row["words"].split(";"))


@cache
def fillers() -> frozenset[str]:
    """Words without information about the category: file jargon, numbers, units, colours, sizes, sides."""
    return frozenset(word for row in rows_of("fillers.csv") for word in row["words"].split(";"))


@cache
def file_jargon() -> frozenset[str]:
    """The fillers that are about files and their making, of three letters or more."""
    words = (w for row in rows_of("fillers.csv") if row["kind"] == "file" for w in row["words"].split(";"))
    return frozenset(word for word in words if len(word) > 2)


def rows_of(file: str) -> Iterator[dict[str, str]]:
    """The rows of a table of this folder."""
    with resources.files("assetkit").joinpath("taxonomy", file).open(encoding="utf-8") as text:
        yield from csv.DictReader(text)
