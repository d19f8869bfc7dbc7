"""`counted`: a condition holds for exactly so many of several objects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.combine.logic import each
from task.predicates.protocol import ROLE, Objects, Part, Predicate, items

MEMBER = "$member"


class Counted(Predicate):
    """`where` holds or not for every member, which `$member` in place of an object's name stands for.

    `exactly` refuses extra ones, as counts of public suites do not; `at_least` and `at_most` bound the number.
    """

    func: ClassVar[str] = "counted"
    needs: ClassVar[frozenset[str]] = frozenset()
    members: Objects
    where: Part
    exactly: int | None = Field(default=None, ge=0)
    at_least: int | None = Field(default=None, ge=0)
    at_most: int | None = Field(default=None, ge=0)

    @model_validator(mode="after")
    def _a_number(self) -> Self:
        bounds = (self.at_least, self.at_most)
        if (self.exactly is None) == (bounds == (None, None)):
            raise ValueError("give `exactly`, or `at_least` and `at_most`")
        if MEMBER not in set(self.where.objects()):
            raise ValueError(f"`where` must speak of `{MEMBER}`")
        return self

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        results, after = each(for_members(self.where, self.members), frames, carry)
        number = np.sum(results, axis=0)
        if self.exactly is not None:
            return number == self.exactly, after
        low = 0 if self.at_least is None else self.at_least
        high = len(self.members) if self.at_most is None else self.at_most
        return (number >= low) & (number <= high), after

    @override
    def objects(self) -> Iterator[str]:
        return (name for name in super().objects() if name != MEMBER)


def for_members(where: Predicate, members: tuple[str, ...]) -> tuple[Predicate, ...]:
    """The condition for each member."""
    return tuple(renamed(where, {MEMBER: name}) for name in members)


def renamed(predicate: Predicate, names: Mapping[str, str]) -> Predicate:
    """The predicate with other names of objects, also in its parts."""

    def changed(item: object, is_role: bool) -> object:
        if isinstance(item, Predicate):
            return renamed(item, names)
        return names.get(item, item) if is_role and isinstance(item, str) else item

    changes: dict[str, object] = {}
    for name, field in type(predicate).model_fields.items():
        value = getattr(predicate, name)
        after = tuple(changed(item, ROLE in field.metadata) for item in items(value))
        changes[name] = after if isinstance(value, tuple) else after[0]
    return predicate.model_copy(update=changes)
