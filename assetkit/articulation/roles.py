"""Roles that the joints of an object give it: openable, turnable, pressable."""

from __future__ import annotations

from collections.abc import Sequence

from assetkit.articulation.interaction_group import ROLE_OF_TASK
from schemas.articulation import JointUse
from schemas.evidence import Evidence, inferred


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
