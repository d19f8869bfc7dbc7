"""Bootstrap samples of a mechanism's trials: readings simulated by a model with the same stamps, inputs and noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, rollout
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.input_timing import InputTiming, with_timing
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.windows import cut, windows_of
from simgap.problem import Model
from simgap.recording.recording import Trial


def bootstrap_sample(
    declared: MechanismModel,
    trials: Sequence[Trial],
    logs: Sequence[Log],
    model: Model,
    timing: InputTiming,
    step_s: float,
    seed: int,
) -> tuple[Trial, ...]:
    """The trials as `model` would have moved from their starts under their inputs, read with their noise.

    `timing` is that of `logs`. Steps are at most `step_s` long; noise is white, of the size that each log shows.
    """
    applied = apply_terms(declared, model)
    true = [applied.recovered(_as_read(with_timing(t, timing), g)) for t, g in zip(trials, logs, strict=True)]
    windows = windows_of([(s, cut(len(s.t_s), None)) for s in true], applied)
    q, _ = rollout(applied.mechanism, windows, applied.laws, largest_step_s=step_s)
    rng = np.random.default_rng(seed)
    out = []
    for trial, log, series, moved in zip(trials, logs, true, q, strict=True):
        columns = {**series.columns, "q": moved[: len(series.t_s)]}
        seen = applied.reported(Series(series.t_s, columns))
        noise = rng.normal(0.0, 1.0, trial.q.shape) * log.smooth.q_noise
        out.append(replace(trial, t_s=seen.t_s, q=seen.columns["q"] + noise))
    return tuple(out)


def _as_read(trial: Trial, log: Log) -> Series:
    """Every row of a trial: smoothed motion, inputs and side channels."""
    columns: dict[str, FloatArray] = {"q": log.smooth.q, "qd": log.smooth.qd, "qdd": log.smooth.qdd}
    columns |= {n: np.nan_to_num(getattr(trial, n)) for n in ("effort", "command") if trial.has(n)}
    columns |= {f"aux:{n}": np.asarray(v, dtype=float)[:, None] for n, v in trial.aux.items()}
    return Series(trial.t_s, columns)
