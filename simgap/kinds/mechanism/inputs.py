"""Permutation of inputs: each trial's motion with the commands and efforts of another trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from simgap.recording.recording import Trial

_SAME_INPUT_SHARE = 0.3  # share of the inputs' size; trials that differ by less are driven alike


def permuted_inputs(trials: Sequence[Trial], by: int = 1) -> tuple[Trial, ...] | None:
    """Each trial with commands and efforts of the one `by` places on, at equal times since the start.

    None where nothing drives, or where all trials are driven alike: then nothing could be distinguished.
    """
    names = [n for n in ("command", "effort") if trials and all(t.has(n) for t in trials)]
    if not names or len(trials) < 2:
        return None
    out, differ = [], []
    for place, trial in enumerate(trials):
        other = trials[(place + by) % len(trials)]
        given = {n: _read_at(other, n, trial.t_s) for n in names}
        own = {n: np.nan_to_num(getattr(trial, n)) for n in names}
        differ.append(max(_apart(own[n], given[n]) for n in names))
        out.append(replace(trial, **given))
    return tuple(out) if np.median(differ) > _SAME_INPUT_SHARE else None


def _read_at(trial: Trial, name: str, t_s: FloatArray) -> FloatArray:
    values = np.nan_to_num(getattr(trial, name))
    rows = np.clip(np.searchsorted(trial.t_s, t_s, side="right") - 1, 0, len(trial.t_s) - 1)
    return values[rows]


def _apart(a: FloatArray, b: FloatArray) -> float:
    """Root mean square difference over the size of both, each about its own mean."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float(np.sqrt(((a - b) ** 2).mean() / max(0.5 * ((a**2).mean() + (b**2).mean()), 1e-300)))
