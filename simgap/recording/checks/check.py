"""Types of a check, and the summary of findings over many trials as one diagnostic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Label, Location, Severity, finding
from schemas.measurement import MeasurementSpec
from simgap.recording.reading.subject import JointInfo
from simgap.recording.recording import Trial

_SHOWN = 5


@dataclass(frozen=True)
class Setting:
    """Inputs of a check besides the trials. `joints` are the measured ones, in the order of `Trial.q`."""

    spec: MeasurementSpec
    joints: tuple[JointInfo, ...] = ()

    @property
    def turns(self) -> FloatArray:
        """(j,) whether a joint is an angle."""
        return np.array([joint.turns for joint in self.joints], dtype=bool)


class Checked(NamedTuple):
    """The trials, repaired where that is safe, and what was found."""

    trials: tuple[Trial, ...]
    found: tuple[Diagnostic, ...] = ()


Check = Callable[[Setting, tuple[Trial, ...]], Checked]


class Hit(NamedTuple):
    """One trial's finding: how bad, and what in words."""

    trial: Trial
    value: float
    text: str


def over_trials(
    code: str,
    headline: str,
    hits: Sequence[Hit],
    total: int,
    *,
    bound: float | None = None,
    unit: str = "",
    severity: Severity | None = None,
) -> tuple[Diagnostic, ...]:
    """One diagnostic for all hits, worst trial first, or nothing; the other trials are its labels."""
    if not hits:
        return ()
    ranked = sorted(hits, key=lambda hit: -abs(hit.value))
    share = f" ({len(hits)} of {total} trials)" if total > 1 else ""
    labels = tuple(Label(where=Location(file=hit.trial.file), text=hit.text) for hit in ranked[:_SHOWN])
    worst = ranked[0]
    return (
        finding(
            code,
            f"{headline}{share}; {worst.trial.id}: {worst.text}",
            where=Location(file=worst.trial.file),
            value=float(worst.value),
            bound=bound,
            unit=unit,
            labels=labels,
            severity=severity,
        ),
    )


def mapped(trials: Sequence[Trial], change: Callable[[Trial], Trial]) -> tuple[Trial, ...]:
    """Every trial through one function."""
    return tuple(change(trial) for trial in trials)
