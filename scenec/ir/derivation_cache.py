"""What a compile derived for single things, kept for the next one of the same session."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from operator import is_
from typing import Any, TypeVar

Value = TypeVar("Value")


class Memo:
    """Values by key, each with the objects that decided it.

    A value is taken over while these are the very same objects as when it was made; they are never changed in place, so
    what was made anew counts as changed. `turn` forgets what was not asked for since the last turn.
    """

    def __init__(self) -> None:
        self._last: dict[Hashable, tuple[tuple[object, ...], Any]] = {}
        self._now: dict[Hashable, tuple[tuple[object, ...], Any]] = {}

    def get(self, key: Hashable, make: Callable[[], Value], *made_of: object) -> Value:
        """The value of a key as it was made of the same objects, else made now."""
        entry = self._now.get(key) or self._last.get(key)
        if entry is None or not all(map(is_, entry[0], made_of)):
            entry = made_of, make()
        self._now[key] = entry
        return entry[1]

    def turn(self) -> None:
        """Forget what has not been used since the last turn."""
        self._last, self._now = self._now, {}
