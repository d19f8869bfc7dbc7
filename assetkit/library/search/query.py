"""What a request asks for, wish by wish."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Field = Literal[
    "category", "family", "role", "outcome", "colour", "material", "size_m", "height_m", "mass_kg",
    "anchor", "task", "part", "text",
]  # fmt: skip


@dataclass(frozen=True)
class Wish:
    """One thing asked for.

    words    of the request (or the flag) that say it.        values  any of these will do, in the field's vocabulary.
    low, high  limits of a figure in the field's unit.        reading what the words were taken for.
    names_thing  whether it says what kind of thing is wanted: without an answer to it nothing is a hit.
    soft     an asset without it ranks lower and is still a hit.
    stated   only what the record states counts, no mere chance (flags).
    denied   it must not be so: "not red", "without a handle".
    """

    words: str
    field: Field
    values: tuple[str, ...] = ()
    low: float = 0.0
    high: float = float("inf")
    reading: str = ""
    names_thing: bool = False
    soft: bool = False
    stated: bool = False
    denied: bool = False
