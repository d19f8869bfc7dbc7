"""`all_of`, `any_of`, `negation`: several conditions at once, one of several, none."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Part, Predicate


class AllOf(Predicate):
    """Every one of the conditions holds in the same frame."""

    func: ClassVar[str] = "all_of"
    needs: ClassVar[frozenset[str]] = frozenset()
    of: tuple[Part, ...] = Field(min_length=1)

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        results, after = each(self.of, frames, carry)
        return np.logical_and.reduce(results), after


class AnyOf(Predicate):
    """At least one of the conditions holds."""

    func: ClassVar[str] = "any_of"
    needs: ClassVar[frozenset[str]] = frozenset()
    of: tuple[Part, ...] = Field(min_length=1)

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        results, after = each(self.of, frames, carry)
        return np.logical_or.reduce(results), after


class Negation(Predicate):
    """The condition does not hold."""

    func: ClassVar[str] = "negation"
    needs: ClassVar[frozenset[str]] = frozenset()
    of: Part

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        result, after = self.of.values(frames, self.of.start() if carry is None else carry[0])
        return ~result, (after,)


def each(parts: tuple[Predicate, ...], frames: Frames, carry: Any) -> tuple[list[BoolArray], Any]:
    """Values of several predicates, and what each carries."""
    before = [part.start() for part in parts] if carry is None else carry
    pairs = [part.values(frames, one) for part, one in zip(parts, before, strict=True)]
    return [values for values, _ in pairs], [after for _, after in pairs]
