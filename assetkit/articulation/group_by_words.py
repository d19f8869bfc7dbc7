"""Interaction groups of a joint by words: names of the joint, of the moved link and of what is welded into it.

From names into chances of groups (0 to 1), and words that name a moved part of no group (limbs, wheels).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from assetkit.taxonomy.tables import interaction_groups, other_motions
from assetkit.taxonomy.words import singulars, words_of
from schemas.mechanism import MechanismJoint, MechanismLink

# How much a name tells (judgements): that of the link, of the joint, of a link that is welded into it.
BY_LINK, BY_JOINT, BY_MEMBER = 0.75, 0.7, 0.6
NOT_LAST = 0.6  # factor: in "drawer_knob" the last word says what it is
WITHIN_WORD = 0.8  # factor for a word within a longer one: "leftdoorhinge"
LEAST_WITHIN = 4  # letters of a word that is searched for within longer ones


@dataclass(frozen=True)
class WordReading:
    """Chances of groups by words, and the clues; `other` is a word that names a moved part outside all groups."""

    chances: Mapping[str, float]
    clues: tuple[str, ...] = ()
    other: str = ""


def read_words(joint: MechanismJoint, link: MechanismLink) -> WordReading:
    """The groups that names mean; words of groups with other types of joints are left out.

    A button that turns is no push button; its name is no evidence for another group.
    """
    names = [(link.name, BY_LINK, "link"), (joint.source_name or joint.name, BY_JOINT, "joint")]
    names += [(member, BY_MEMBER, "link") for member in link.members if member != link.name]
    chances: dict[str, float] = {}
    clues: list[str] = []
    other = ""
    for name, weight, place in names:
        for group, share in _groups_in(name):
            if joint.kind in interaction_groups()[group].joints:
                chances[group] = max(chances.get(group, 0.0), round(weight * share, 3))
                clues.append(f"{place} '{name}'")
        if not other and place != "member":
            other = next((word for word in words_of(name) if word in other_motions()), "")
    return WordReading(chances, tuple(dict.fromkeys(clues)), "" if chances else other)


def _groups_in(name: str) -> Iterator[tuple[str, float]]:
    """Groups that a name means, each with the share of its weight: 1 for the last word."""
    words = words_of(name)
    for group, phrases in moved_words().items():
        for phrase in phrases:
            ends = list(_ends_of(phrase.split(), words))
            if ends:
                yield group, 1.0 if max(ends) >= _last_with_meaning(words) else NOT_LAST
            elif len(phrase) >= LEAST_WITHIN and any(phrase.replace(" ", "") in word for word in words):
                yield group, WITHIN_WORD


def moved_words() -> dict[str, tuple[str, ...]]:
    """Names of the moved part of each group: the words of the table and the first of its parts."""
    return {group.id: tuple(dict.fromkeys((*group.words, group.parts[0]))) for group in interaction_groups().values()}


def _ends_of(phrase: Sequence[str], words: Sequence[str]) -> Iterator[int]:
    """Positions behind each occurrence of a phrase, its last word perhaps in the plural."""
    for start in range(len(words) - len(phrase) + 1):
        here = words[start : start + len(phrase)]
        if tuple(here[:-1]) == tuple(phrase[:-1]) and phrase[-1] in (here[-1], *singulars(here[-1])):
            yield start + len(phrase)


def _last_with_meaning(words: Sequence[str]) -> int:
    """Position behind the last word that belongs to any group; 0 without one."""
    phrases = [phrase.split() for group in moved_words().values() for phrase in group]
    return max((end for phrase in phrases for end in _ends_of(phrase, words)), default=0)
