"""What people decide about parts: replayed on the very region they saw; and which doubts are worth their time."""

from __future__ import annotations

from collections.abc import Sequence

from assetkit.parts.labels import ANYWHERE
from assetkit.taxonomy.tables import categories
from jobs.cache import content_key
from schemas.decision import Decision
from schemas.evidence import Evidence, declared, default
from schemas.parts import UNLABELLED, Part

# The parts without which a thing cannot play its role: what it is held by, and what moves.
NEEDED: dict[str, tuple[str, ...]] = {
    "manipulated": ("handle",),
    "tool": ("handle",),
    "receptacle": ("lid", "spout"),
    "mechanism": ("door", "drawer", "lid", "cap", "knob", "button", "pedal", "flap"),
}
PLAYED = 0.5  # A role counts from this confidence on.


def region_of(part: Part) -> str:
    """Names the region of a part, whatever it is called and however many others there are."""
    return content_key([[f.mesh, f.ranges] for f in part.faces])


def with_decided(parts: Sequence[Evidence[Part]], decisions: Sequence[Decision]) -> tuple[Evidence[Part], ...]:
    """The parts with the labels that people gave them, oldest decision first; an empty one withdraws the earlier."""
    said: dict[str, tuple[str, str]] = {}
    for decision in decisions:
        for decided in decision.parts.values():
            said[decided.region] = (decided.label, decision.by)
    made = []
    for evidence in parts:
        label, by = said.get(region_of(evidence.value), ("", ""))
        made.append(evidence.model_copy(update={"value": _called(evidence.value, label, by)}) if label else evidence)
    return tuple(made)


def lost(parts: Sequence[Evidence[Part]], decisions: Sequence[Decision]) -> tuple[str, ...]:
    """Ids under which people decided about regions that are no parts any more."""
    regions = {region_of(p.value) for p in parts}
    return tuple(sorted({i for d in decisions for i, said in d.parts.items() if said.region not in regions}))


def in_doubt(parts: Sequence[Evidence[Part]], roles: Sequence[Evidence[str]]) -> tuple[Part, ...]:
    """Parts without a label because clues differ, where one of the roles depends on what they are."""
    needed = {label for role in roles if role.confidence >= PLAYED for label in NEEDED.get(role.value, ())}
    return tuple(p.value for p in parts if needed & set(p.value.may_be))


def names_for(category: str) -> tuple[str, ...]:
    """What a part of a thing of that category may be called; "unlabelled" when it has no name."""
    known = categories().get(category)
    return (*(known.parts if known else ANYWHERE), UNLABELLED)


def _called(part: Part, label: str, by: str) -> Part:
    how = f"decision by {by}"
    evidence = default(UNLABELLED, how) if label == UNLABELLED else declared(label, how)
    name = part.name if label == UNLABELLED else label
    return part.model_copy(update={"label": evidence, "name": name, "may_be": ()})
