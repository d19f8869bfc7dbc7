"""Votes for the label of a region, by its names in the source and by its shape in things of its category."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from assetkit.taxonomy.words import singulars, words_of
from schemas.parts import ProposalSource

if TYPE_CHECKING:  # It brings all that finds regions, which `mana review` only names.
    from assetkit.parts.proposals import Proposal

# How much a clue counts (judgements): a node that is called so, a render material, a plain shape, a less plain one.
BY_NODE, BY_MATERIAL, BY_SHAPE, BY_FAINT_SHAPE = 0.8, 0.6, 0.7, 0.6
WITHOUT_CATEGORY = 0.7  # factor on the confidence when the category is unknown
# Words that name a part of anything; "back", "head" or "top" do so only in the right category.
ANYWHERE = ("handle", "lid", "knob", "drawer", "door", "leg", "spout", "wheel", "button", "blade", "cap")

_ROLES: dict[str, dict[str, str]] = {
    **{key: {"loop": "handle", "arm": "handle", "cover": "lid"} for key in ("mug", "cup", "pan", "pot")},
    **{key: {"loop": "handle", "arm": "spout", "cover": "lid"} for key in ("pitcher", "teapot")},
    **{key: {"loop": "handle"} for key in ("basket", "box", "bin", "tray")},
    **{key: {"slab": "top", "post": "leg"} for key in ("table", "desk")},
    **{key: {"slab": "seat", "post": "leg"} for key in ("stool", "bench")},
    "chair": {"slab": "seat", "post": "leg", "upright": "back"},
    **{key: {"cover": "cap", "stopper": "cap", "neck": "neck"} for key in ("bottle", "pill_bottle")},
    "jar": {"cover": "lid"},
    "vase": {"neck": "neck"},
    "drinking_glass": {"stem": "stem", "over": "bowl", "foot": "foot"},
    # A bowl, tines, a head are wider than what the hand holds, a blade is thinner, a shaft slimmer.
    "spoon": {"broad": "bowl", "slim": "handle"},
    "fork": {"broad": "tines", "slim": "handle"},
    "knife": {"thin": "blade", "stout": "handle"},
    **{key: {"broad": "head", "slim": "handle"} for key in ("cooking_utensil", "hammer")},
    "screwdriver": {"slim": "shaft", "broad": "handle"},
    "scissors": {"slim": "blade", "broad": "handle"},
    "block": {"boss": "stud"},
}
_FAINT = ("arm", "upright", "cover", "stopper")


@dataclass(frozen=True)
class Vote:
    """A label with its confidence, the kind of the clue that supports it, and the clue in words."""

    label: str
    confidence: float
    kind: ProposalSource
    clue: str


def votes(proposal: Proposal, category: str, vocabulary: Sequence[str]) -> tuple[Vote, ...]:
    """Votes for the label of the proposal's region, by name and by shape."""
    if proposal.label:
        return (Vote(proposal.label, proposal.confidence, "learned", f"segmenter {proposal.by}".strip()),)
    return (*_by_name(proposal, vocabulary), *_by_shape(proposal, category))


def _by_name(proposal: Proposal, vocabulary: Sequence[str]) -> tuple[Vote, ...]:
    strength = {"hierarchy": BY_NODE, "material": BY_MATERIAL}.get(proposal.source, proposal.confidence)
    for name in proposal.names:
        label = label_in_name(name, vocabulary or ANYWHERE)
        if label is not None and strength > 0.0:
            sure = strength if vocabulary else WITHOUT_CATEGORY * strength
            return (Vote(label, sure, proposal.source, f"{proposal.source} '{name}'"),)
    return ()


def _by_shape(proposal: Proposal, category: str) -> tuple[Vote, ...]:
    label = _ROLES.get(category, {}).get(proposal.role)
    if label is None:
        return ()
    sure = BY_FAINT_SHAPE if proposal.role in _FAINT else BY_SHAPE
    return (Vote(label, sure, "shape", f"shape: {proposal.role}"),)


def label_in_name(name: str, vocabulary: Sequence[str]) -> str | None:
    """The part a name ends with or holds last, None when it names none: `Chair_Leg_FL` is a leg."""
    words = words_of(name)
    last: tuple[int, str] | None = None
    for part in vocabulary:
        part_words = tuple(part.split())
        for start in range(len(words) - len(part_words) + 1):
            here = words[start : start + len(part_words)]
            ends = (here[-1], *singulars(here[-1]))
            if here[:-1] == part_words[:-1] and part_words[-1] in ends:
                last = max(last or (-1, ""), (start + len(part_words), part))
    return None if last is None else last[1]
