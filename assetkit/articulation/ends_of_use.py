"""Which position of a joint is shut and which fully open (released and pressed, off and on), with confidence.

From the room that the object takes over the range, the side of the body, and the rest state; positions in rad or m.
"""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.articulation.group_by_shape import pressed_position
from assetkit.articulation.interaction_group import tasks
from assetkit.articulation.joint_view import JointView
from geom.articulation.closed_position import ClosedPosition
from schemas.evidence import Evidence, default, inferred

# Judgements: the room that the object takes, with the rest state there and elsewhere; the rest state alone; the side
# on which the body lies, with the head released at rest and not.
BY_ROOM_AT_REST, BY_ROOM, BY_REST = 0.85, 0.6, 0.5
BY_SIDE_AT_REST, BY_SIDE = 0.85, 0.6
BOTH_WAYS = 0.5  # factor: which of two ways it is opened is open
CLEAR_GROWTH = 0.1  # of the box: below it the room tells less
LITTLE = 0.75  # factor
AT_REST = 0.05  # of the range: the rest state is at a position within it


@dataclass(frozen=True)
class EndsOfUse:
    """The two ends of the use of a joint."""

    closed: Evidence[float]
    open: Evidence[float]


def find_ends(view: JointView, group: str, shut: ClosedPosition | None) -> EndsOfUse:
    """The ends of the use of a joint of a `group`, which may be unknown; `shut` as of `closed_position`."""
    low, high = view.limits
    if view.is_endless:
        return _unknown(low, high, "turns without end")
    task = tasks().get(group)
    if task == "press":
        return _pressed(view)
    if task == "open" and shut is not None:
        at_rest = _is_near(view, shut.closed, view.joint.rest)
        confidence = BY_ROOM_AT_REST if at_rest else BY_ROOM
        confidence *= LITTLE if shut.growth < CLEAR_GROWTH else 1.0
        clue = "the object takes least room" + (" at rest" if at_rest else "")
        opened = confidence * (BOTH_WAYS if shut.both_ways else 1.0)
        way = "the farther of two ends" if shut.both_ways else "the end where it takes more room"
        return EndsOfUse(
            inferred(shut.closed, clue, round(confidence, 3)),
            inferred(shut.open, way, round(opened, 3), inputs=(clue,)),
        )
    at_low, at_high = (_is_near(view, end, view.joint.rest) for end in (low, high))
    if at_low == at_high or task is None:
        return _unknown(low, high, "rest between the ends" if at_low == at_high else "unknown group")
    closed, is_open = (low, high) if at_low else (high, low)
    return EndsOfUse(inferred(closed, "rest state", BY_REST), inferred(is_open, "the end away from rest", BY_REST))


def _pressed(view: JointView) -> EndsOfUse:
    low, high = view.limits
    pressed = pressed_position(view)
    if pressed is None:
        return _unknown(low, high, "no side of the body is nearer")
    released = low if pressed == high else high
    confidence = BY_SIDE_AT_REST if _is_near(view, released, view.joint.rest) else BY_SIDE
    return EndsOfUse(inferred(released, "out of the body", confidence), inferred(pressed, "into the body", confidence))


def _unknown(low: float, high: float, reason: str) -> EndsOfUse:
    return EndsOfUse(default(low, reason), default(high, reason))


def _is_near(view: JointView, position: float, other: float) -> bool:
    return abs(position - other) <= AT_REST * view.span
