"""Collision filtering between two bodies: joints, filtered pairs, self-collision of articulations."""

from __future__ import annotations

from typing import Any

from gate.subject.body import Body
from gate.subject.joint import Joint
from gate.subject.values import flag

_SELF_COLLISION = ("physxArticulation:enabledSelfCollisions", "newton:selfCollisionEnabled")


def may_collide(first: Body, second: Body, joint: Joint | None) -> bool:
    """False when a joint between them, a filtered pair or their articulation switches contacts off."""
    if joint is not None and not joint.collides:
        return False
    if filtered_pair(first, second):
        return False
    root = _shared_root(first.prim, second.prim)
    while root and not root.IsPseudoRoot():
        if any(not flag(root, name, fallback=True) for name in _SELF_COLLISION):
            return False
        root = root.GetParent()
    return True


def filtered_pair(first: Body, second: Body) -> bool:
    """True iff the file says of these two that they do not collide."""
    return _filters(first, second) or _filters(second, first)


def _filters(first: Body, second: Body) -> bool:
    """True iff a filtered-pairs relationship on `first` or its colliders names `second`, or something around it."""
    for prim in (first.prim, *(c.prim for c in first.colliders)):
        relationship = prim.GetRelationship("physics:filteredPairs")
        for target in relationship.GetForwardedTargets() if relationship else ():
            if second.prim.GetPath().HasPrefix(target) or target.HasPrefix(second.prim.GetPath()):
                return True
    return False


def _shared_root(first: Any, second: Any) -> Any:
    path = first.GetPath().GetCommonPrefix(second.GetPath())
    return first.GetStage().GetPrimAtPath(path)
