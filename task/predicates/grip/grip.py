"""How a gripper holds an object: by at least two of its fingers, as observed contacts say."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from schemas.arrays import BoolArray
from task.frames import Frames

FINGERS_THAT_HOLD = 2  # one finger touches or pushes, two on one thing close on it

Bodies: TypeAlias = frozenset[str]


def fingers_on(frames: Frames, name: str, gripper: str | None = None) -> BoolArray:
    """(n,) whether a gripper, this one or any, has the object between its fingers. Raises StateMissing."""
    bodies = bodies_of(frames, name)
    result = np.zeros(len(frames), dtype=bool)
    for each in frames.log.grippers:
        if gripper not in (None, each.name):
            continue
        touching = sum(
            (frames.touches_any(finger, bodies).astype(np.int64) for finger in each.fingers),
            start=np.zeros(len(frames), dtype=np.int64),
        )
        result |= touching >= min(FINGERS_THAT_HOLD, len(each.fingers))
    return result


def is_held(frames: Frames, name: str) -> BoolArray:
    """(n,) whether any gripper has the object between its fingers; never where the log has no gripper."""
    return fingers_on(frames, name) if frames.log.grippers else np.zeros(len(frames), dtype=bool)


def bodies_of(frames: Frames, name: str) -> Bodies:
    """All bodies of an object: its own and those of its links."""
    facts = frames.facts(name)
    return frozenset({facts.body, *facts.bodies.values()})


def gripper_bodies(frames: Frames) -> Bodies:
    """Fingers and palms of all grippers."""
    return frozenset(name for each in frames.log.grippers for name in (each.palm, *each.fingers))
