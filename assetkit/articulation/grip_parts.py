"""Labels of parts that turn out to be the handle or knob of a joint, and the contacts that name them.

A grip that stands out of the face of a link is often a nameless shape of the source; its joint is what it is for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.articulation import JointContact, JointUse
from schemas.evidence import Evidence, inferred
from schemas.parts import UNLABELLED, Part

GRIPS = ("handle", "knob")
BESIDE = 0.1  # of the diagonal of the contact's box: a part of the grip lies within it around the box


def label_grips(
    parts: Sequence[Evidence[Part]], uses: Sequence[JointUse]
) -> tuple[tuple[Evidence[Part], ...], tuple[JointUse, ...]]:
    """The parts, those within the box of a handle or knob labelled so, and the uses with the largest of them.

    A part with a label, or with clues that contradict each other, keeps it.
    """
    labelled = list(parts)
    named: list[JointUse] = []
    for use in uses:
        contact = use.contact
        if contact is None or contact.value.part is not None or contact.value.kind not in GRIPS:
            named.append(use)
            continue
        members = [i for i, p in enumerate(labelled) if _belongs(p.value, contact.value)]
        for i in members:
            labelled[i] = _with_label(labelled[i], use, contact)
        if members:
            largest = max(members, key=lambda i: labelled[i].value.area_m2)
            part_id = labelled[largest].value.part_id
            known = contact.model_copy(update={"value": contact.value.model_copy(update={"part": part_id})})
            use = use.model_copy(update={"contact": known})
        named.append(use)
    return tuple(labelled), tuple(named)


def _belongs(part: Part, contact: JointContact) -> bool:
    """Whether an unlabelled part of the link lies within the box of the contact."""
    if part.link != contact.link or part.label.value != UNLABELLED or part.may_be:
        return False
    low, high = np.array(contact.low_m), np.array(contact.high_m)
    spare = BESIDE * float(np.linalg.norm(high - low))
    return bool((np.array(part.low_m) >= low - spare).all() and (np.array(part.high_m) <= high + spare).all())


def _with_label(part: Evidence[Part], use: JointUse, contact: Evidence[JointContact]) -> Evidence[Part]:
    kind = contact.value.kind
    label = inferred(kind, f"{kind} of joint {use.joint}", contact.confidence, inputs=(contact.method,))
    return part.model_copy(update={"value": part.value.model_copy(update={"label": label, "name": kind})})
