"""What a kind of measurement provides for inference on whole trials: errors of a model whose starts are free."""

from __future__ import annotations

from typing import Protocol

from schemas.arrays import FloatArray
from simgap.problem import Model


class TrialSystem(Protocol):
    """Trials (t) with errors in noise levels. The value of a method depends on its arguments alone."""

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """The trials, in the order of all arrays."""
        ...

    @property
    def start_steps(self) -> FloatArray:
        """(t, s) sizes of changes of each start value, about its noise; s is 0 where starts are not free."""
        ...

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        """(m, t, n) simulated minus measured, in noise levels, for m sets of starts (m, t, s) in `start_steps`.

        NaN where nothing was measured. A simulation that diverges gives large finite numbers.
        """
        ...
