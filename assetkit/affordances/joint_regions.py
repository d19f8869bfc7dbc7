"""Affordance regions of an articulated object: where its joints are opened, turned or pressed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.affordances import WHOLE, Interaction, Region
from schemas.articulation import JointContact, JointUse
from schemas.evidence import Evidence, inferred

REGION_DIGITS = 6  # of recorded lengths in metres: a micrometre


def joint_regions(uses: Sequence[JointUse]) -> tuple[Evidence[Region], ...]:
    """A region for the contact of each joint of a known group, as sure as the contact and the group both are."""
    regions: list[Evidence[Region]] = []
    counts: dict[str, int] = {}
    for use in uses:
        if use.contact is None or use.group.confidence == 0.0:
            continue
        contact = use.contact.value
        number = counts.setdefault(contact.kind, 0)
        counts[contact.kind] += 1
        region = _region(use, contact, f"{contact.kind}_{number}")
        confidence = round(min(use.contact.confidence, use.group.confidence), 3)
        method = f"contact of joint {use.joint}: {use.contact.method}"
        regions.append(inferred(region, method, confidence, inputs=(use.joint,)))
    return tuple(regions)


def _region(use: JointUse, contact: JointContact, region_id: str) -> Region:
    """The box of a contact: its middle, its longest edge as outline, and its shortest edge as size."""
    low, high = np.array(contact.low_m), np.array(contact.high_m)
    edges = high - low
    along = np.zeros(3)
    along[int(edges.argmax())] = 0.5 * float(edges.max())
    middle = 0.5 * (low + high)
    return Region(
        kind=contact.kind,
        affordance_id=region_id,
        part=contact.part or WHOLE,
        task=use.task,
        interaction=_interaction(use, contact),
        position_m=contact.position_m,
        direction=contact.normal,
        outline_m=(_point(middle - along), _point(middle + along)),
        size_m=round(float(edges.min()), REGION_DIGITS),
        joint=use.joint,
    )


def _interaction(use: JointUse, contact: JointContact) -> Interaction:
    """Knobs are twisted, buttons, levers and platforms pushed; what opens is pulled, as it moves out of its face."""
    if use.task == "press":
        return "push"
    if use.task == "turn":
        return "twist" if contact.kind == "knob" else "push"
    return "pull" if float(np.dot(contact.pull, contact.normal)) > 0.0 else "push"


def _point(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (round(float(v), REGION_DIGITS) + 0.0 for v in values)
    return x, y, z
