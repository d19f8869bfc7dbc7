"""Reads one name: the category that it means, or another thing, and how much that counts.

In English compounds the last noun is the thing: a "mug holder" is no mug, a "coffee mug white v2" is one. So the
longest known names in a name are found, inside and outside the vocabulary, and the last before a preposition counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from assetkit.taxonomy.material_classes import materials
from assetkit.taxonomy.tables import Category, categories, file_jargon, fillers, other_things
from assetkit.taxonomy.words import singulars, words_of

# Probability that a name is right, without its shape (a judgement, checked by `benchmarks.assets.semantics`).
# `CLEAR`: its last noun, unmistakable. `LIKELY`: unknown words follow, or the noun means other things as well, is a
# plural, or not the only thing named. `FAINT`: two of these.
CLEAR, LIKELY, FAINT = 0.75, 0.5, 0.2
_PREPOSITIONS = frozenset(("of", "with", "for", "in", "on", "and", "from", "without"))
_COUNTED = frozenset(("count", "pack", "packs", "ct", "pk", "pcs", "assorted", "assortment", "set", "kit"))
_EDIBLE = "food"  # As plurals these are mostly names of packages: "peaches" is a can.


@dataclass(frozen=True)
class NameReading:
    """The reading of a name: a category with the words for it and its strength, or something else.

    other             the words of a thing outside the vocabulary, or of a part, when the name means one, else "".
    is_uninformative  whether the name has no information: jargon, numbers, colours.
    unknown_before, unknown_after  whether unknown words are beside the noun.
    """

    category: str | None = None
    words: str = ""
    strength: float = 0.0
    other: str = ""
    is_uninformative: bool = False
    unknown_before: bool = False
    unknown_after: bool = False


def category_by_name(name: str) -> Category | None:
    """The category that a whole name means, as a user states it ("mug", "Coffee mugs"), or None."""
    if name in categories():
        return categories()[name]
    match = _look_up(words_of(name))
    return None if match is None or match[0].category is None else categories()[match[0].category]


@dataclass(frozen=True)
class _Entry:
    category: str | None
    weak: bool = False


@dataclass(frozen=True)
class _Mention:
    start: int
    end: int
    entry: _Entry
    plural: bool


def read_name(name: str) -> NameReading:
    """The reading of a name, a file stem, folder, node, material or title."""
    words = words_of(name)
    mentions = _without_adjectives(words, _mentions(words))
    if not mentions:
        return NameReading(is_uninformative=all(_is_filler(word) for word in words))
    phrase_end = next((i for i, w in enumerate(words) if w in _PREPOSITIONS and i >= mentions[0].end), len(words))
    head = [m for m in mentions if m.end <= phrase_end][-1]
    head_words = " ".join(words[head.start : head.end])
    if head.entry.category is None:
        beside = (words[: head.start], words[head.end : phrase_end])
        before, after = (not all(_is_filler(word) for word in part) for part in beside)
        return NameReading(other=head_words, unknown_before=before, unknown_after=after)
    doubts = sum(_doubts(words[:phrase_end], head)) + int(_names_another(mentions, head))
    return NameReading(head.entry.category, head_words, (CLEAR, LIKELY, FAINT)[min(doubts, 2)])


def _doubts(words: Sequence[str], head: _Mention) -> tuple[int, ...]:
    """How far from clear: an ambiguous noun (more so behind an unknown word), unknown words behind it, a plural, a
    count as packages of several things have it.
    """
    before = head.start > 0 and not _is_filler(words[head.start - 1])
    behind = not all(_is_filler(word) for word in words[head.end :])
    return (
        int(head.entry.weak),
        int(head.entry.weak and before),
        int(behind),
        (2 if _edible(head) else 1) * int(head.plural),
        int(not _COUNTED.isdisjoint(words)),
    )


@cache
def _is_filler(word: str) -> bool:
    """Whether a word has no information, also as two words of file jargon in one ("lowpolymesh", "newmodel")."""
    halves = ((word[:k], word[k:]) for k in range(3, len(word) - 2))
    return word in fillers() or any(file_jargon().issuperset(pair) for pair in halves)


def _edible(mention: _Mention) -> bool:
    return mention.entry.category is not None and categories()[mention.entry.category].family == _EDIBLE


def _names_another(mentions: Sequence[_Mention], head: _Mention) -> bool:
    """Whether the name mentions another category that is no part of the noun: "coffee mug 16 oz cup"."""
    return any(m.end < head.start and m.entry.category not in (None, head.entry.category) for m in mentions)


def _mentions(words: Sequence[str]) -> list[_Mention]:
    """The longest known names from left to right, none overlapping; parts may be written as one word or several."""
    mentions: list[_Mention] = []
    start = 0
    while start < len(words):
        for end in range(min(len(words), start + _longest()), start, -1):
            hit = _look_up(words[start:end])
            if hit is not None:
                mentions.append(_Mention(start, end, *hit))
                start = end
                break
        else:
            start += 1
    return mentions


def _look_up(words: Sequence[str]) -> tuple[_Entry, bool] | None:
    """The entry of these words, and whether they are its plural."""
    known = _lexicon()
    joined = "".join(words)
    if joined in known:
        return known[joined], False
    plural_of = (form for form in singulars(joined) if form in known)
    singular = next(plural_of, None)
    return None if singular is None else (known[singular], True)


def _without_adjectives(words: Sequence[str], mentions: list[_Mention]) -> list[_Mention]:
    """Without colours, materials and contents ("orange", "glass", "avocado"), where another thing is named as well."""
    nouns = [m for m in mentions if m.end - m.start > 1 or words[m.start] not in _adjectives()]
    return [m for m in nouns if not _edible(m)] or nouns or mentions


@cache
def _adjectives() -> frozenset[str]:
    return fillers() | frozenset(w for m in materials().values() if m.name != "food" for w in m.words)


@cache
def _lexicon() -> dict[str, _Entry]:
    """Every known name, written as one word."""
    known = {"".join(words_of(name)): _Entry(None) for name in other_things()}
    for category in categories().values():
        known |= {"".join(words_of(name)): _Entry(category.id, weak=True) for name in category.weak_aliases}
        known |= {"".join(words_of(name)): _Entry(category.id) for name in category.aliases}
    return known


@cache
def _longest() -> int:
    names = [*other_things(), *(a for c in categories().values() for a in (*c.aliases, *c.weak_aliases))]
    return max(len(words_of(name)) for name in names)
