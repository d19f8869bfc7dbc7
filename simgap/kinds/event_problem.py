"""Base protocol of event measurements (impacts, pushes): rows with a state before and after, no time series."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from schemas.arrays import FloatArray
from schemas.gap import ConventionCheck
from simgap.problem import Problem


@runtime_checkable
class EventProblem(Problem, Protocol):
    """A problem whose rows have no time; short horizon and full roll-out are the same."""

    @property
    def convention_checks(self) -> tuple[ConventionCheck, ...]:
        """Conventions of the record that were checked."""
        ...

    def readings(self, trials: Sequence[str]) -> list[FloatArray]:
        """Per trial (k, c) what was measured, row by row beside the residuals."""
        ...

    def slices(self, features: FloatArray) -> dict[str, FloatArray]:
        """(k,) masks of rows by the words of the report for their common property."""
        ...
