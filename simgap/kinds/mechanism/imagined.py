"""Recordings of a mechanism that could be made next, as a model would give them: other inputs, starts or loads.

From the trials that exist, which show what the rig can do, and a model to trials with simulated readings and noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, rollout
from sim.dynamics.tree import mass_matrix
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.windows import Cut, windows_of
from simgap.problem import ImaginedRecording, Model

if TYPE_CHECKING:
    from simgap.kinds.mechanism.whole_trials import MechanismTrials

_LOAD = 0.5  # of a joint's inertia
_COPIES = 3  # of what was recorded
_WIDEST = 3.0  # times the positions of the recording: farther out the model knows nothing


@dataclass(frozen=True)
class Experiment:
    """A change of what was recorded: of a trial's inputs and start, or of the mechanism by a known amount."""

    name: str
    words: str
    trial: Callable[[Series], Series] = lambda series: series
    mechanism: Callable[[MechanismModel], MechanismModel] = lambda model: model
    copies: int = 1


def imagined_recordings(trials: MechanismTrials, model: Model, seed: int = 0) -> tuple[ImaginedRecording, ...]:
    """Each experiment as it would be recorded if `model` were true; those beyond the joints' limits are left out."""
    driven = trials.declared.drive.type != "none"
    out: list[ImaginedRecording] = []
    for number, experiment in enumerate(_driven() if driven else _free()):
        system = _recorded(trials, model, experiment, seed + number)
        if system is not None:
            out.append(ImaginedRecording(experiment.name, experiment.words, system, experiment.copies))
    return tuple(out)


def _same() -> list[Experiment]:
    return [
        Experiment("repeats", f"record the same trials {_COPIES} more times", copies=_COPIES),
        Experiment("known_load", "repeat with a known inertia added to each joint", mechanism=_loaded),
    ]


def _driven() -> list[Experiment]:
    return [
        Experiment("smaller", "repeat with half the inputs", lambda s: _scaled(s, 0.5)),
        Experiment("slower", "repeat at half the speed", lambda s: _stretched(s, 2.0)),
        Experiment("larger", "repeat with 1.5 times the inputs", lambda s: _scaled(s, 1.5)),
        Experiment("faster", "repeat at twice the speed", lambda s: _stretched(s, 0.5)),
        Experiment("mirrored", "repeat with mirrored inputs", lambda s: _scaled(s, -1.0)),
        *_same(),
    ]


def _free() -> list[Experiment]:
    return [
        Experiment("smaller", "let it go from half as far", lambda s: _released(s, 0.5)),
        Experiment("larger", "let it go from 1.5 times as far", lambda s: _released(s, 1.5)),
        Experiment("mirrored", "let it go from the other side", lambda s: _released(s, -1.0)),
        *_same(),
    ]


def _scaled(series: Series, by: float) -> Series:
    """Efforts times a number; commands' way from their start times it."""
    columns = dict(series.columns)
    if "effort" in columns:
        columns["effort"] = by * columns["effort"]
    if "command" in columns:
        first = columns["command"][:1]
        columns["command"] = first + by * (columns["command"] - first)
    return Series(series.t_s, columns)


def _stretched(series: Series, by: float) -> Series:
    """The same inputs in `by` times the time, at the same rate of rows."""
    step = float(np.median(np.diff(series.t_s)))
    t_s = np.arange(0.0, by * (series.t_s[-1] - series.t_s[0]) + 0.5 * step, step)
    then = series.t_s[0] + t_s / by
    columns: dict[str, FloatArray] = {}
    for name, values in series.columns.items():
        columns[name] = np.stack([np.interp(then, series.t_s, column) for column in values.T], axis=1)
    columns["qd"] = columns["qd"] / by
    return Series(t_s, columns)


def _released(series: Series, by: float) -> Series:
    """The start's distance from the middle of the motion times a number."""
    columns = dict(series.columns)
    middle = np.nanmean(columns["q"], axis=0)
    columns["q"] = middle + by * (columns["q"] - middle)
    columns["qd"] = by * columns["qd"]
    return Series(series.t_s, columns)


def _loaded(model: MechanismModel) -> MechanismModel:
    inertia = np.diag(mass_matrix(model.tree, np.zeros((1, len(model.tree))))[0])
    added = [replace(k, armature=k.armature + _LOAD * float(m)) for k, m in zip(model.tree, inertia, strict=True)]
    return replace(model, tree=tuple(added))


def _recorded(trials: MechanismTrials, model: Model, experiment: Experiment, seed: int) -> MechanismTrials | None:
    """The experiment with readings as the model gives them, in the noise of the trials; None beyond limits."""
    declared = experiment.mechanism(trials.declared)
    applied = apply_terms(declared, model)
    rng = np.random.default_rng(seed)
    asked = [applied.recovered(experiment.trial(log.series)) for log in trials.logs]
    whole = [Cut(np.arange(len(s.t_s))[None], np.arange(len(s.t_s))) for s in asked]
    q, qd = rollout(
        applied.mechanism, windows_of(list(zip(asked, whole, strict=True)), applied), applied.laws,
        largest_step_s=trials.step_s,
    )  # fmt: skip
    if not _within_limits(trials, q):
        return None
    logs = tuple(
        _log(log, series, applied, q[i, : len(series.t_s)], qd[i, : len(series.t_s)], trials.noise, rng)
        for i, (log, series) in enumerate(zip(trials.logs, asked, strict=True))
    )
    longest = max(len(log.series.t_s) for log in logs)
    missing = np.ones((len(logs), longest, trials.channel_count), dtype=bool)
    for i, log in enumerate(logs):
        missing[i, : len(log.series.t_s)] = False
    return replace(trials, declared=declared, logs=logs, missing=missing)


def _log(
    log: Log,
    series: Series,
    applied: Applied,
    q: FloatArray,
    qd: FloatArray,
    noise: FloatArray,
    rng: np.random.Generator,
) -> Log:
    """Simulated motion as a log: columns as read."""
    read = applied.read_off(series.t_s[None], q[None], np.array([len(q)]))[0]
    noisy = read + noise * rng.standard_normal(read.shape)
    accelerations = np.gradient(qd, series.t_s, axis=0)
    columns = {**series.columns, "reading": noisy, "q": read, "qd": qd, "qdd": accelerations}
    return Log(Series(series.t_s, columns), log.smooth, log.block)


def _within_limits(trials: MechanismTrials, q: FloatArray) -> bool:
    """Whether a motion stays within declared limits, and near enough to what was recorded."""
    limits = trials.declared.limits
    if limits is not None and bool(((q < limits[:, 0]) | (q > limits[:, 1])).any()):
        return False
    read = np.concatenate([log.series.columns["q"] for log in trials.logs])
    middle = 0.5 * (np.nanmin(read, axis=0) + np.nanmax(read, axis=0))
    half = 0.5 * np.ptp(read, axis=0)
    return bool(np.isfinite(q).all()) and bool((np.abs(q - middle) <= _WIDEST * half + 1e-9).all())
