"""Parses a request in English into criteria: limits first, then phrases, the kind of object, colours and materials.

A word outside the vocabularies becomes a criterion on the texts of the assets. In English compounds the last noun is
the head: a "mug holder" is no mug (as in `annotate.name_reading`).
"""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from itertools import groupby
from typing import NamedTuple

from assetkit.annotate.name_reading import category_by_name
from assetkit.library.search.limits import read_limits
from assetkit.library.search.query import Criterion
from assetkit.taxonomy.material_classes import materials
from assetkit.taxonomy.tables import Category, categories, families, fillers, other_things
from assetkit.taxonomy.words import singulars, words_of

_LONGEST = 4
_SIZES_M = {"tiny": (0.0, 0.03), "small": (0.0, 0.10), "large": (0.30, float("inf")), "huge": (1.0, float("inf"))}
_EDIBLE = "food"  # As a material it is what things hold, not what they are made of: "bowl for fruit".
_JOINING = frozenset(("or", "and"))
_BEFORE_NEGATED = frozenset(("a", "an", "the", "any", "for", "to"))
_ALTERNATIVE = frozenset(("or", "nor"))


class _Phrase(NamedTuple):
    kind: str
    value: str


class _Noun(NamedTuple):
    start: int
    end: int
    category: Category | None
    family: str = ""


def parse_query(request: str) -> tuple[Criterion, ...]:
    """The criteria of a request, in the order of their kinds; () when it is empty. A request without any meaningful
    word is a criterion on the texts, so that it finds nothing rather than everything.
    """
    plain = unicodedata.normalize("NFC", request).lower()
    limits, rest = read_limits(plain)
    words = re.findall(r"[^\W\d_]+|\d+|;", rest)
    taken: dict[int, _Phrase] = dict(_phrases(words))
    negated = _negated_positions(words, taken)
    kinds, kind_positions = _kind_criteria(words, taken, negated)
    left = [i for i in range(len(words)) if i not in taken and i not in kind_positions and words[i] != ";"]
    kind_categories = [categories()[v] for c in kinds if c.field == "category" for v in c.values]
    phrases = [
        replace(_of_phrase(phrase, text, kind_categories), negated=bool({i for i in negated if taken.get(i) == phrase}))
        for phrase, text in _phrase_texts(words, taken)
        if phrase.kind not in ("stop", "not")
    ]
    excluded, excluded_positions = _excluded_kinds(words, [i for i in left if i in negated])
    properties = [_property(words, i, kinds) for i in left if i not in excluded_positions]
    of_words = [_negation(criterion) if i in negated else criterion for i, criterion in properties]
    criteria = (*kinds, *excluded, *of_words, *phrases, *limits)
    if criteria or not plain.strip():
        return criteria
    return (Criterion(request.strip(), "text", reading="nothing that could be looked for"),)


def _negated_positions(words: Sequence[str], taken: dict[int, _Phrase]) -> set[int]:
    """Positions negated by "not" (the next word or name) and "without" (all words up to the next phrase, over "or")."""
    negated: set[int] = set()
    for i, phrase in taken.items():
        if phrase.kind != "not" or taken.get(i + 1) == phrase:
            continue
        j = i + 1
        while j < len(words) and words[j] in _BEFORE_NEGATED and taken[j].kind == "stop":
            j += 1
        end = j + 1
        while end < len(words) and (taken.get(end) == taken.get(j) or words[end] in _ALTERNATIVE) and words[end] != ";":
            end += 1
        if phrase.value == "one" and j not in taken:
            end = max((e for e in range(j + 1, j + _LONGEST) if _noun(words, j, min(e, len(words)))), default=j + 1)
        negated |= set(range(j, end)) & set(range(len(words)))
    return negated


def _excluded_kinds(words: Sequence[str], positions: Sequence[int]) -> tuple[tuple[Criterion, ...], set[int]]:
    """Negated kinds of objects, and the positions that name them: "not a mug", "other than a coffee mug"."""
    heads = [_head(words, list(run)) for run in _consecutive(positions)]
    nouns = [noun for noun in heads if noun is not None and noun.category is not None]
    criteria = []
    for noun in nouns:
        category = noun.category.id if noun.category else ""
        phrase = " ".join(words[noun.start : noun.end])
        criteria.append(_negation(Criterion(phrase, "category", (category,), reading=f"category {category}")))
    return tuple(criteria), {i for noun in nouns for i in range(noun.start, noun.end)}


def _consecutive(positions: Sequence[int]) -> Iterator[list[int]]:
    """Runs of positions that follow one another."""
    for _, run in groupby(enumerate(positions), key=lambda entry: entry[1] - entry[0]):
        yield [position for _, position in run]


def _negation(criterion: Criterion) -> Criterion:
    return replace(
        criterion, words=f"not {criterion.words}", reading=f"not: {criterion.reading}", negated=True, optional=False
    )


def _phrases(words: Sequence[str]) -> Iterator[tuple[int, _Phrase]]:
    """Positions that belong to a phrase of the table, the longest phrases first."""
    known, start = _table(), 0
    while start < len(words):
        for end in range(min(len(words), start + _LONGEST), start, -1):
            phrase = known.get(tuple(words[start:end]))
            if phrase is not None:
                yield from ((i, phrase) for i in range(start, end))
                start = end
                break
        else:
            start += 1


def _phrase_texts(words: Sequence[str], taken: dict[int, _Phrase]) -> Iterator[tuple[_Phrase, str]]:
    """Each phrase once, with its words."""
    for phrase in dict.fromkeys(taken.values()):
        yield phrase, " ".join(words[i] for i, p in taken.items() if p == phrase)


def _of_phrase(phrase: _Phrase, words: str, kinds: Sequence[Category]) -> Criterion:
    if phrase.kind == "size":
        return _size_word(phrase.value, words, kinds)
    reading = {"task": "something to", "anchor": "an anchor of kind", "role": "the role"}[phrase.kind]
    field = "task" if phrase.kind == "task" else "anchor" if phrase.kind == "anchor" else "role"
    return Criterion(words, field, (phrase.value,), reading=f"{reading} {phrase.value}")


def _size_word(value: str, words: str, kinds: Sequence[Category]) -> Criterion:
    """A size word is relative to the usual sizes of the category: "small" is below the middle of their range."""
    low, high = _SIZES_M[value]
    if len(kinds) == 1:
        usual = kinds[0].large_m
        middle = (usual[0] * usual[1]) ** 0.5
        low, high = (0.0, middle) if value in ("tiny", "small") else (middle, float("inf"))
    reading = f"longest edge {low:.3g} to {high:.3g} m" + (f", as {kinds[0].id} go" if len(kinds) == 1 else "")
    return Criterion(words, "size_m", low=low, high=high, reading=reading, optional=True)


def _kind_criteria(
    words: Sequence[str], taken: dict[int, _Phrase], negated: set[int]
) -> tuple[tuple[Criterion, ...], set[int]]:
    """The criterion on the kind of object, and the positions that name it; () when no category or family is named.

    The head of the first run of words that holds a noun is the kind; the heads of runs that "or" and "and" join to it
    are alternatives.
    """
    runs = [run for run in _runs(words, taken) if run]
    heads = [(run, _head(words, run)) for run in runs]
    known = [(run, noun) for run, noun in heads if noun is not None and noun.start not in negated]
    if not known or (known[0][1].category is None and not known[0][1].family):
        return (), set()
    chosen = [known[0]]
    for run, noun in known[1:]:
        between = words[chosen[-1][1].end : run[0]]
        if not set(between) & _JOINING or set(between) - {*_JOINING, "a", "an", "the", ";"} or not noun.category:
            break
        chosen.append((run, noun))
    nouns = [noun for _, noun in chosen]
    used = {i for noun in nouns for i in range(noun.start, noun.end)}
    phrase = " or ".join(" ".join(words[n.start : n.end]) for n in nouns)
    if nouns[0].family:
        title = families()[nouns[0].family].title
        return (Criterion(phrase, "family", (nouns[0].family,), reading=f"family {title}", is_kind=True),), used
    values = tuple(dict.fromkeys(n.category.id for n in nouns if n.category))
    return (Criterion(phrase, "category", values, reading=f"category {' or '.join(values)}", is_kind=True),), used


def _runs(words: Sequence[str], taken: dict[int, _Phrase]) -> Iterator[list[int]]:
    """Runs of consecutive positions that belong to no phrase."""
    run: list[int] = []
    for i, word in enumerate(words):
        if i in taken or word == ";":
            yield run
            run = []
        else:
            run.append(i)
    yield run


def _head(words: Sequence[str], run: Sequence[int]) -> _Noun | None:
    """The last noun of a run; a colour or material counts only where there is no other noun."""
    nouns: list[_Noun] = []
    start, stop = run[0], run[-1] + 1
    while start < stop:
        for end in range(min(stop, start + _LONGEST), start, -1):
            noun = _noun(words, start, end)
            if noun is not None:
                nouns.append(noun)
                start = end
                break
        else:
            start += 1
    proper = [n for n in nouns if n.end - n.start > 1 or not _is_adjective(words[n.start])]
    return (proper or nouns or [None])[-1]


def _noun(words: Sequence[str], start: int, end: int) -> _Noun | None:
    name = " ".join(words[start:end])
    family = _families().get(name)
    if family:
        return _Noun(start, end, None, family)
    category = category_by_name(name)
    if category is not None:
        return _Noun(start, end, category)
    outside = any(form in _outside() for form in (name, *singulars(name)))
    return _Noun(start, end, None) if outside and not _is_adjective(name) else None


def _property(words: Sequence[str], i: int, kinds: Sequence[Criterion]) -> tuple[int, Criterion]:
    """Position and criterion of a word that is neither in a phrase nor a kind: colour, material, part or text."""
    from assetkit.materials.colour_names import colour_by_name  # Loads matplotlib.

    word = words[i]
    colour = colour_by_name(word) if word in fillers() else None
    if colour is not None:
        return i, Criterion(word, "colour", (colour,), reading=f"colour {colour}")
    forms = (word, *singulars(word))
    made_of = tuple(m.name for m in materials().values() if m.name != _EDIBLE and (word == m.name or word in m.words))
    if made_of:
        return i, Criterion(word, "material", made_of, reading=f"material {' or '.join(made_of)}")
    part = next((form for form in forms if form in _parts()), None)
    if part is not None and (kinds or "with" in words[:i]):
        return i, Criterion(word, "part", (part,), reading=f"a part called {part}")
    return i, Criterion(word, "text", forms, reading="a word in the texts of the asset", optional=bool(kinds))


def _is_adjective(word: str) -> bool:
    return word in fillers() or any(word == m.name or word in m.words for m in materials().values())


@cache
def _table() -> dict[tuple[str, ...], _Phrase]:
    with resources.files("assetkit").joinpath("library", "search", "phrases.csv").open(encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    return {tuple(p.split()): _Phrase(row["kind"], row["value"]) for row in rows for p in row["words"].split(";")}


@cache
def _families() -> dict[str, str]:
    """Family ids by their names: the id in words, with and without a plural s."""
    named = {family.replace("_", " "): family for family in families()}
    return named | {name.removesuffix("s"): family for name, family in named.items()}


@cache
def _outside() -> frozenset[str]:
    return frozenset(" ".join(words_of(name)) for name in other_things())


@cache
def _parts() -> frozenset[str]:
    return frozenset(part for category in categories().values() for part in category.parts)
