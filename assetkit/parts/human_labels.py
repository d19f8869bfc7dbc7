"""Part labels from human decisions, applied to the region that the person saw; and the disputes that need a person."""

from __future__ import annotations

from collections.abc import Sequence

from assetkit.parts.labels import ANYWHERE
from assetkit.taxonomy.tables import categories
from jobs.cache import content_key
from schemas.decision import Decision
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, default
from schemas.parts import UNLABELLED, Part

# The parts without which a thing cannot play its role: what it is held by, and what moves.
LABELS_NEEDED_BY_ROLE: dict[str, tuple[str, ...]] = {
    "manipulated": ("handle",),
    "tool": ("handle",),
    "receptacle": ("lid", "spout"),
    "mechanism": ("door", "drawer", "lid", "cap", "knob", "button", "pedal", "flap"),
}
MIN_ROLE_CONFIDENCE = 0.5  # A role counts from this confidence on.


def region_key(part: Part) -> str:
    """A hash of the region of a part, independent of its label and of other parts."""
    return content_key([[f.mesh, f.ranges] for f in part.faces])


def with_human_labels(parts: Sequence[Evidence[Part]], decisions: Sequence[Decision]) -> tuple[Evidence[Part], ...]:
    """The parts with the labels that people gave them, oldest decision first; an empty one withdraws the earlier."""
    label_of_region: dict[str, tuple[str, str]] = {}
    for decision in decisions:
        for decided in decision.parts.values():
            label_of_region[decided.region] = (decided.label, decision.by)
    labelled = []
    for evidence in parts:
        label, by = label_of_region.get(region_key(evidence.value), ("", ""))
        labelled.append(
            evidence.model_copy(update={"value": _called(evidence.value, label, by)}) if label else evidence
        )
    return tuple(labelled)


def outdated_regions(parts: Sequence[Evidence[Part]], decisions: Sequence[Decision]) -> tuple[str, ...]:
    """Ids of decisions about regions that are no parts any more."""
    regions = {region_key(p.value) for p in parts}
    return tuple(sorted({i for d in decisions for i, decided in d.parts.items() if decided.region not in regions}))


def disputed_parts(parts: Sequence[Evidence[Part]], roles: Sequence[Evidence[str]]) -> tuple[Part, ...]:
    """Parts without a label because clues differ, where one of the roles depends on their label."""
    needed = {
        label
        for role in roles
        if role.confidence >= MIN_ROLE_CONFIDENCE
        for label in LABELS_NEEDED_BY_ROLE.get(role.value, ())
    }
    return tuple(p.value for p in parts if needed & set(p.value.may_be))


def allowed_labels(category: str) -> tuple[str, ...]:
    """What a part of a thing of that category may be called; "unlabelled" when it has no name."""
    known = categories().get(category)
    return (*(known.parts if known else ANYWHERE), UNLABELLED)


def _called(part: Part, label: str, by: str) -> Part:
    how = f"decision by {by}"
    evidence = default(UNLABELLED, how) if label == UNLABELLED else declared(label, how)
    name = part.name if label == UNLABELLED else label
    return part.model_copy(update={"label": evidence, "name": name, "may_be": ()})


def dispute_findings(parts: Sequence[Evidence[Part]]) -> list[Diagnostic]:
    """One warning for each contradiction, with all parts that it leaves without a label."""
    texts: dict[str, list[Part]] = {}
    for part in (p.value for p in parts if p.value.may_be):
        texts.setdefault(part.label.method, []).append(part)
    names = {text: " and ".join(_either(p) for p in group) for text, group in texts.items()}
    return [finding("asset/part-disputed", f"{parts_of}: {text}") for text, parts_of in names.items()]


def _either(part: Part) -> str:
    return f"{part.part_id} ({' or '.join(part.may_be)})"
