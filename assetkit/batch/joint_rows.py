"""The joints of a package as rows of a table for people: kind, range, use, handle, swept volume, what moves along."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from schemas.anchors import Anchor
from schemas.articulation import JointUse

LITRES_PER_M3 = 1e3
UNSURE = 0.5  # a value with less confidence is marked


@dataclass(frozen=True)
class JointRow:
    """One joint; lengths in cm, angles in degrees, the swept volume in litres (None: unknown).

    range_text  both limits, or "endless". `opens` is from where to where it opens, turns on or is pressed, and `handle`
                where it is moved; both are "" for joints without a use of their own: followers and closing joints.
    unsure      the names of those of `group`, `opens`, `handle` whose confidence is below `UNSURE`.
    carries     the ids of the anchors that follow the joint: those of its child and of all links beyond it.
    """

    name: str
    kind: str
    child: str
    range_text: str
    group: str
    opens: str
    handle: str
    swept_l: float | None
    carries: tuple[str, ...]
    unsure: tuple[str, ...]


def joint_rows(
    joints: Sequence[dict[str, Any]], uses: Sequence[JointUse], anchors: Sequence[Anchor]
) -> tuple[JointRow, ...]:
    """A row for each of `joints`, as `physics.joints` of a record gives them, in their order."""
    use_of = {use.joint: use for use in uses}
    by_link: dict[str, list[str]] = {}
    for anchor in anchors:
        by_link.setdefault(anchor.link or "", []).append(anchor.anchor_id)
    return tuple(_row(joint, joints, use_of.get(joint["name"]), by_link) for joint in joints)


def _row(
    joint: dict[str, Any], joints: Sequence[dict[str, Any]], use: JointUse | None, by_link: dict[str, list[str]]
) -> JointRow:
    limits = joint.get("limits_rad", joint.get("limits_m"))
    carries = tuple(anchor for link in _links_beyond(joint, joints) for anchor in by_link.get(link, ()))
    range_text = "endless" if limits is None else _span(joint, *limits)
    if use is None:
        return JointRow(joint["name"], joint["type"], joint["child"], range_text, "", "", "", None, carries, ())
    contact = use.contact
    confidence = {
        "group": use.group.confidence,
        "opens": min(use.closed.confidence, use.open.confidence),
        "handle": contact.confidence if contact is not None else 1.0,
    }
    return JointRow(
        name=joint["name"],
        kind=joint["type"],
        child=joint["child"],
        range_text=range_text,
        group=use.group.value,
        opens=f"{use.task}: {_span(joint, use.closed.value, use.open.value)} ({'+' if use.sense > 0 else '−'})",
        handle="" if contact is None else f"{contact.value.kind} ({contact.value.part or contact.value.link})",
        swept_l=None if use.swept is None else LITRES_PER_M3 * use.swept.volume_m3,
        carries=carries,
        unsure=tuple(name for name, value in confidence.items() if value < UNSURE),
    )


def _links_beyond(joint: dict[str, Any], joints: Sequence[dict[str, Any]]) -> list[str]:
    """The child of a joint and all links beyond it, each once, nearest first."""
    links = [joint["child"]]
    for link in links:
        links += [j["child"] for j in joints if j["parent"] == link and j["child"] not in links]
    return links


def _span(joint: dict[str, Any], start: float, end: float) -> str:
    """Two positions (m or rad) of a joint, in cm or degrees."""
    if joint["type"] == "prismatic":
        return f"{100.0 * start:.3g} to {100.0 * end:.3g} cm"
    return f"{math.degrees(start):.3g} to {math.degrees(end):.3g}°"
