"""What the joints of an object make of it: its roles (openable, turnable, pressable) and its interaction group."""

from __future__ import annotations

from collections.abc import Sequence

from assetkit.articulation.interaction_group import ROLE_OF_TASK
from schemas.articulation import JointUse
from schemas.evidence import Evidence, inferred


def roles_with_joints(roles: Sequence[Evidence[str]], uses: Sequence[JointUse]) -> tuple[Evidence[str], ...]:
    """The roles of an object by what it is, then those that its joints give it."""
    return (*roles, *roles_of_joints(uses))


def roles_of_joints(uses: Sequence[JointUse]) -> tuple[Evidence[str], ...]:
    """One role per task that a joint of a known group serves, as sure as the surest of these groups."""
    roles: list[Evidence[str]] = []
    for task, role in ROLE_OF_TASK.items():
        known = [u for u in uses if u.task == task and u.group.confidence > 0.0]
        if known:
            confidence = max(u.group.confidence for u in known)
            clues = tuple(f"{u.joint}: {u.group.value}" for u in known)
            roles.append(inferred(role, "interaction groups of its joints", confidence, inputs=clues))
    return tuple(roles)


def group_of_joints(uses: Sequence[JointUse]) -> Evidence[str] | None:
    """The group that most joints of a known group have, the surest of equally many; None where none is known."""
    known = [u.group for u in uses if u.group.confidence > 0.0]
    if not known:
        return None
    sure = {value: max(g.confidence for g in known if g.value == value) for value in {g.value for g in known}}
    group = max(sure, key=lambda value: (sum(g.value == value for g in known), sure[value], value))
    clues = tuple(f"{u.joint}: {u.group.value}" for u in uses if u.group.confidence > 0.0)
    return inferred(group, "interaction groups of its joints", sure[group], inputs=clues)
