"""Cache of values derived for single objects of a problem, kept from one compile of a session to the next."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from operator import is_
from typing import Any, TypeVar

Value = TypeVar("Value")


class DerivationCache:
    """Values by key, each with the objects that decided it.

    A value stays valid while these are the very same Python objects as when it was made. They are never changed in
    place, so that a new object counts as changed. `drop_unused` drops values not used since its last call.
    """

    def __init__(self) -> None:
        self._last: dict[Hashable, tuple[tuple[object, ...], Any]] = {}
        self._now: dict[Hashable, tuple[tuple[object, ...], Any]] = {}

    def get(self, key: Hashable, make: Callable[[], Value], *made_of: object) -> Value:
        """The cached value of a key where it was made of the same objects, else the value of `make`."""
        entry = self._now.get(key) or self._last.get(key)
        if entry is None or not all(map(is_, entry[0], made_of)):
            entry = made_of, make()
        self._now[key] = entry
        return entry[1]

    def drop_unused(self) -> None:
        """Drops all values that were not used since the last call."""
        self._last, self._now = self._now, {}
