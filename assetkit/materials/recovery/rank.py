"""Ranks entries of the library for one surface: the terms of the score, before and after the pictures.

The score is a sum of natural logarithms. What is known of the surface comes first and picks the entries that are drawn;
what the pictures show can move a choice only between entries that are nearly as likely.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from assetkit.materials.colour_names import BASIC_TERMS, basic_terms
from assetkit.materials.recovery.families import FamilyChances
from assetkit.materials.recovery.library import LibraryMaterial, classes_of
from assetkit.taxonomy.words import words_of

DRAWN: Final = 4  # candidates per surface: with four views each, 16 small pictures, under a second
MOST_OF_CLASS: Final = 2  # of them of one class, so that other families are looked at too
_LEAST_CHANCE: Final = 1e-4  # of a class: the logarithm stays finite
# A name that states a colour outweighs how usual the entry's colour is in its class (at most a factor of 60).
NAMED_COLOUR: Final = 5.0
# So does a name that holds the entry's own word (banana, marble, brass), among entries of the likeliest family only:
# a toy brick is of plastic.
NAMED_ENTRY: Final = 5.0
# Pictures: at most a factor of e^0.5 for shape, e^0.4 for what looks like its neighbours, e^2 for a colour by name.
SHAPE, CLIPPED, LIKE_NEIGHBOUR, SHOWN_COLOUR = 0.5, 1.0, -0.4, 2.0
_FULL_CONTRAST = 0.08  # standard deviation of lightness (0..1) from which a lit shape is read without effort
_ALIKE_LAB = 8.0  # distance in CIELAB below which two surfaces look like one material


@dataclass(frozen=True)
class Candidate:
    """An entry with the terms of its score by name."""

    entry: LibraryMaterial
    terms: Mapping[str, float]

    @property
    def score(self) -> float:
        """The sum of all terms."""
        return sum(self.terms.values())


@dataclass(frozen=True)
class DrawnSurface:
    """What the standard views show of one surface under one candidate.

    contrast  standard deviation of its lightness, 0..1.    clipped  share of its pixels that are black or white.
    neighbour_lab  distance to the mean colour of trustworthy surfaces in the same pictures; None without any.
    colour_shares  of basic colour terms among its pixels.
    """

    contrast: float
    clipped: float
    neighbour_lab: float | None
    colour_shares: Mapping[str, float]


def shortlist(
    chances: FamilyChances, entries: Sequence[LibraryMaterial], colour: str | None, names: Sequence[str] = ()
) -> tuple[Candidate, ...]:
    """The `DRAWN` likeliest entries, at most `MOST_OF_CLASS` of a class, best first; ties by name.

    `names` are those that may hold the word of an entry.
    """
    words = {word for name in names for word in words_of(name)}
    most_usual: dict[str, float] = {}
    for entry in entries:
        most_usual[entry.material_class] = max(most_usual.get(entry.material_class, 0.0), entry.usual)
    candidates = (_known(entry, chances, most_usual[entry.material_class], colour, words) for entry in entries)
    taken: list[Candidate] = []
    for candidate in ranked(tuple(candidates)):
        same = [other for other in taken if other.entry.material_class == candidate.entry.material_class]
        if len(same) < MOST_OF_CLASS:
            taken.append(candidate)
        if len(taken) == DRAWN:
            break
    return tuple(taken)


def with_picture(candidate: Candidate, drawn: DrawnSurface, colour: str | None) -> Candidate:
    """The candidate with the terms of what its pictures show."""
    terms = {
        "shape in the pictures": SHAPE * min(drawn.contrast / _FULL_CONTRAST, 1.0) - CLIPPED * drawn.clipped,
    }
    if drawn.neighbour_lab is not None:
        terms["looks like its neighbours"] = LIKE_NEIGHBOUR * max(0.0, 1.0 - drawn.neighbour_lab / _ALIKE_LAB)
    if colour is not None:
        terms[f"{colour} in the pictures"] = SHOWN_COLOUR * drawn.colour_shares.get(colour, 0.0)
    return replace(candidate, terms={**candidate.terms, **{name: round(value, 3) for name, value in terms.items()}})


def ranked(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The candidates, the highest score first; ties by name."""
    return tuple(sorted(candidates, key=_order))


def stated_colour(names: Sequence[str]) -> str | None:
    """The basic colour term that the first name with one states; those that are also things (orange) are left out."""
    for name in names:
        for word in words_of(name):
            term = {"gray": "grey"}.get(word, word)
            if term in BASIC_TERMS and term != "orange":
                return term
    return None


def _known(
    entry: LibraryMaterial, chances: FamilyChances, most_usual: float, colour: str | None, words: AbstractSet[str]
) -> Candidate:
    """The terms before any picture: its family, its class in that, the entry in its class."""
    in_family = [chances.of_class.get(name, 0.0) for name in classes_of(entry.family)]
    terms = {
        "family": math.log(max(chances.of_family(entry.family), _LEAST_CHANCE)),
        "class in its family": math.log(
            max(chances.of_class.get(entry.material_class, 0.0), _LEAST_CHANCE) / max(*in_family, _LEAST_CHANCE)
        ),
        "usual in its class": math.log(entry.usual / most_usual),
    }
    if colour is not None:
        terms[f"named {colour}"] = NAMED_COLOUR if basic_terms(np.array([entry.base_color]))[0] == colour else 0.0
    if entry.family == chances.likeliest and (named := sorted(own_words_of(entry) & words)):
        terms[f"named {named[0]}"] = NAMED_ENTRY
    return Candidate(entry, {name: round(value, 3) for name, value in terms.items()})


def own_words_of(entry: LibraryMaterial) -> set[str]:
    """The words of an entry's name that are neither its class or family nor a colour."""
    return set(words_of(entry.name)) - {entry.material_class, entry.family, *BASIC_TERMS}


def _order(candidate: Candidate) -> tuple[float, str]:
    return -round(candidate.score, 6), candidate.entry.name
