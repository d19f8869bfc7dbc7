"""The trials of a mechanism measurement as logs in windows: what every model is rolled out on and compared with.

From a measurement and an input timing into smoothed logs, windows per view, noise floors and equation errors. A value
depends on the arguments alone; what is dear is computed once and kept, so problems at several models share it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, Windows, rollout
from sim.dynamics.tree import mass_matrix
from simgap.inference.fit import Errors, Fit
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.declared_model import build_mechanism
from simgap.kinds.mechanism.equation_error import SPANS, balance, in_noise_levels, refitted
from simgap.kinds.mechanism.input_timing import TIMINGS, InputTiming, possible_timings, with_timing
from simgap.kinds.mechanism.logs import log_of
from simgap.kinds.mechanism.smooth import Smooth
from simgap.kinds.mechanism.time_scale import TimeScale, time_scale
from simgap.kinds.mechanism.windows import Cut, cut, windows_of
from simgap.problem import Model, View
from simgap.recording.read import Measurement

_STEP_SWING = 0.15  # of a radian of the fastest controlled swing per step
_MOST_WINDOWS = 240  # over all trials; each has at least `_LEAST_WINDOWS`
_LEAST_WINDOWS = 6


class WindowedLogs:
    """Smoothed logs of all trials at one input timing, cut into windows of one horizon."""

    def __init__(
        self,
        measurement: Measurement,
        scale: TimeScale | None = None,
        known: Mapping[str, Smooth] | None = None,
        timing: InputTiming = "stamps",
    ) -> None:
        """`scale` and `known` smoothed motions by trial id are those of the readings where they are left out.

        `timing` is when inputs act and rows are read.
        """
        self.measurement = measurement
        self.declared: MechanismModel = build_mechanism(measurement.spec, measurement.root)
        self.scale = scale or time_scale(measurement.trials)
        self.timing: InputTiming = timing
        self.by_trial = {
            t.id: log_of(with_timing(t, timing), self.scale, (known or {}).get(t.id)) for t in measurement.trials
        }
        self.row_s = float(np.median(np.concatenate([np.diff(t.t_s) for t in measurement.trials])))
        step = float(np.median(np.concatenate([np.diff(g.series.t_s) for g in self.by_trial.values()])))
        self.step_s = _largest_step_s(self.declared, self.scale)
        left_open = [possible_timings(t) for t in measurement.trials] if timing == "stamps" else [()]
        self.open_timings: list[InputTiming] = [b for b in TIMINGS[1:] if all(b in some for some in left_open)]
        self._rows = max(4, round(self.scale.radian_s / step) + 1)
        self._windows = max(_LEAST_WINDOWS, _MOST_WINDOWS // len(self.by_trial))
        self._floors: dict[tuple[View, tuple[str, ...]], FloatArray] = {}
        self._gathered: dict[tuple[View, tuple[str, ...]], tuple[tuple[object, ...], Windows]] = {}
        self._balances: dict[tuple[object, ...], tuple[Errors, Fit]] = {}
        self._at_timing: dict[InputTiming, WindowedLogs] = {}

    def smooth(self) -> dict[str, Smooth]:
        """Smoothed motions by trial id."""
        return {name: log.smooth for name, log in self.by_trial.items()}

    def at_timing(self, timing: InputTiming) -> WindowedLogs:
        """The same measurement with another input timing."""
        if timing not in self._at_timing:
            known = self.smooth() if timing != "even" else None
            self._at_timing[timing] = WindowedLogs(self.measurement, self.scale, known, timing)
        return self._at_timing[timing]

    def cut(self, trial: str, view: View) -> Cut:
        """The windows of a trial."""
        log = self.by_trial[trial]
        length = len(log.series.t_s)
        if view == "full_rollout":
            return cut(length, None, log.margin)
        return cut(length, self._rows, log.margin, self._windows)

    def windows_of(
        self, trials: Sequence[str], view: View, pieces: Sequence[tuple[Series, Cut]], applied: Applied
    ) -> Windows:
        """All windows of the trials; kept for models that map readings and inputs in the same way."""
        key = (view, tuple(trials))
        cached = self._gathered.get(key)
        if cached is None or cached[0] != applied.maps:
            self._gathered[key] = cached = applied.maps, windows_of(pieces, applied)
        return cached[1]

    def balance_beside(self, model: Model, trials: Sequence[str]) -> tuple[Errors, Fit]:
        """Equation errors of the trials in noise levels, and the fit of `model` to them."""
        key = (tuple(trials), *((t.candidate.key, *t.values.items()) for t in model))
        if key not in self._balances:
            unexplained = balance(self.declared, [self.by_trial[t] for t in trials], SPANS)
            errors = in_noise_levels(unexplained, model)
            self._balances[key] = errors, refitted(errors, model)
        return self._balances[key]

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """(j,) rms noise of smoothed readings, and the start's carried along by the model.

        In a straight line at most: a controller soon forgets a start, and without one it would grow with any horizon.
        """
        key = (view, tuple(trials))
        if key not in self._floors:
            smooth = [self.by_trial[t].smooth for t in trials]
            read = np.mean([(s.noise_gain * s.q_noise) ** 2 for s in smooth], axis=0)
            ahead = np.mean([(s.qd_noise * self.scale.radian_s) ** 2 / 3.0 for s in smooth], axis=0)
            self._floors[key] = np.sqrt(read + np.minimum(read + ahead, self._carried(trials, view)))
        return self._floors[key]

    def _carried(self, trials: Sequence[str], view: View) -> FloatArray:
        """(j,) mean square of what the declared model makes of the noise of its starts, where roll-outs are judged."""
        applied = apply_terms(self.declared, ())
        pieces = [(self.by_trial[t].series, self.cut(t, view)) for t in trials]
        windows = windows_of(pieces, applied)
        smooth = [(self.by_trial[t].smooth, len(piece.rows)) for t, (_, piece) in zip(trials, pieces, strict=True)]
        noise_q, noise_qd = (
            np.concatenate([np.tile(of(s), (count, 1)) for s, count in smooth])
            for of in (lambda s: s.noise_gain * s.q_noise, lambda s: s.qd_noise)
        )

        def judged(start: Windows) -> FloatArray:
            q, _ = rollout(applied.mechanism, start, applied.laws, largest_step_s=self.step_s)
            rows = np.split(q, np.cumsum([count for _, count in smooth])[:-1])
            return np.concatenate([p.of(r).reshape(-1, q.shape[2]) for r, (_, p) in zip(rows, pieces, strict=True)])

        plain = judged(windows)
        moved = (replace(windows, q0=windows.q0 + noise_q), replace(windows, qd0=windows.qd0 + noise_qd))
        return np.sum([np.nanmean((judged(start) - plain) ** 2, axis=0) for start in moved], axis=0)


def _largest_step_s(declared: MechanismModel, scale: TimeScale) -> float:
    """Steps that follow the motion and the controller's own swing: a step's error must stay below what effects do."""
    if declared.drive.type != "position_pd":
        return scale.largest_step_s
    joints = len(declared.tree)
    inertia = np.diag(mass_matrix(declared.tree, np.zeros((1, joints)))[0])
    stiffness = np.abs(declared.drive.kp * declared.drive.effort_per_unit)
    fastest = float(np.sqrt((stiffness / inertia).max()))
    return float(np.clip(_STEP_SWING / max(fastest, 1e-300), scale.finest_step_s, scale.largest_step_s))
