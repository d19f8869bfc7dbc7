"""What kinds of measurement without time series share: every row is an event with a state before and one after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from schemas.gap import ConventionCheck
from schemas.model import FloatArray
from simgap.problem import Problem


@runtime_checkable
class EventProblem(Problem, Protocol):
    """A problem whose rows have no time; short horizon and full roll-out are the same."""

    @property
    def traps(self) -> tuple[ConventionCheck, ...]:
        """Conventions of the record that were checked."""
        ...

    def readings(self, trials: Sequence[str]) -> list[FloatArray]:
        """Per trial (k, c) what was measured, row by row beside the residuals."""
        ...

    def slices(self, features: FloatArray) -> dict[str, FloatArray]:
        """(k,) masks of rows by the words that say what they have in common."""
        ...
