"""A `free_body` measurement as a problem for the statistics (`simgap.problem.Problem`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from geom.support import heights
from schemas.model import FloatArray
from sim.body_replay import BodyModel, BodyReplay, BodyWindows
from sim.effects.effect import Series
from simgap.free_body.build import build_body
from simgap.free_body.direct import biases_of, estimate
from simgap.free_body.places import candidates_of, nuisances_of
from simgap.free_body.repeats import moved, repeated
from simgap.free_body.terms import AppliedBody, apply_terms
from simgap.free_body.toss import Toss, corners
from simgap.measurement import Measurement
from simgap.problem import Candidate, DirectEstimate, Model, View
from simgap.splits import split_trials
from simgap.trial import Trial

HORIZON_S = 0.081
_LARGEST_M, _LARGEST_RAD = 1e3, np.pi
_COMPARED = 4  # rows per short window that are compared
_IN_FLIGHT, _AT_REST, _IN_CONTACT = 3, 1, 6  # most windows per trial; where nothing is met, few tell all
_FEW, _FINER = 12, 4.0  # trials that tell the error of a step; how much finer steps must be
_CLEAR, _MOVED = 0.1, 0.01  # shares of the body's size: this far from the support all along, moved less than this


class FreeBodyProblem:
    """Engine roll-outs against poses; direct estimates from flight, impacts, sliding and rest."""

    def __init__(self, measurement: Measurement, engine: BodyReplay, horizon_s: float = HORIZON_S) -> None:
        self.measurement = measurement
        self.declared: BodyModel = build_body(measurement.spec, measurement.root)
        self.horizon_s = horizon_s
        self._engine = engine
        self._series = {t.id: _series(t) for t in measurement.trials}
        step = float(np.median(np.concatenate([np.diff(s.t_s) for s in self._series.values()])))
        self._rows = max(4, round(horizon_s / step) + 1)
        self._step_s = step
        self._read: tuple[object, list[Toss]] = (None, [])
        self._biases: dict[str, tuple[FloatArray, ...]] = {}
        self._numeric: dict[tuple[tuple[str, ...], View], FloatArray] = {}

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        return tuple(self._series)

    @cached_property
    def _candidates(self) -> tuple[Candidate, ...]:
        taught = split_trials(self.measurement.spec, self.trial_ids).train
        return candidates_of(self.declared, [self._series[t] for t in taught], lambda c: self.direct(c, (), taught))

    def channels(self) -> tuple[str, ...]:
        """Position and the rotation vector between simulated and measured, world axes."""
        return ("position_x", "position_y", "position_z", "rotation_x", "rotation_y", "rotation_z")

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return self._candidates

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; m and rad."""
        return self._errors(model, trials, view, 1.0)

    def _errors(self, model: Model, trials: Sequence[str], view: View, finer: float) -> list[FloatArray]:
        applied = apply_terms(self.declared, model)
        series = [applied.recovered(self._series[trial]) for trial in trials]
        cuts = [self._cut(trial, view) for trial in trials]
        # Windows of equal length are rolled out together, whatever trial they are of.
        lengths = [rows.shape[1] for rows, _ in cuts]
        out: list[FloatArray] = [np.zeros((0, 6))] * len(series)
        for length in dict.fromkeys(lengths):
            of = [n for n, k in enumerate(lengths) if k == length]
            errors = self._rolled(applied, [series[n] for n in of], [cuts[n][0] for n in of], cuts[of[0]][1], finer)
            for n, found in zip(of, errors, strict=True):
                out[n] = found
        return out

    def _rolled(
        self,
        applied: AppliedBody,
        series: Sequence[Series],
        rows: Sequence[np.ndarray],
        compared: np.ndarray,
        finer: float,
    ) -> list[FloatArray]:
        """Errors (w * c, 6) per series from windows of equally many rows (w, k) each."""

        def picked(name: str, first_only: bool) -> FloatArray:
            parts = zip(series, rows, strict=True)
            return np.concatenate([s.columns[name][r[:, 0] if first_only else r] for s, r in parts])

        # Rows that are not compared need not be stopped at.
        rows, compared = [r[:, [0, *compared]] for r in rows], np.arange(1, len(compared) + 1)
        t_s = np.concatenate([s.t_s[r] for s, r in zip(series, rows, strict=True)])
        start = {name: picked(name, True) for name in ("p", "quat_wxyz", "v_W", "w_B")}
        motion = self._engine.rollout(applied.body, BodyWindows(t_s=t_s, **start), applied.wrenches, finer)
        simulated = _reported(applied, t_s, motion.p, motion.quat_wxyz)
        measured = _reported(applied, t_s, picked("p", False), picked("quat_wxyz", False))
        errors = _errors(*(v[:, compared] for v in (*simulated, *measured)))
        return np.split(errors, np.cumsum([len(r) * len(compared) for r in rows])[:-1])

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Velocity, turning rate (world), height of the lowest point at the start, and the time since."""
        out = []
        for trial in trials:
            series = self._series[trial]
            rows, compared = self._cut(trial, view)
            first = rows[:, 0]
            R = Rotation.from_quat(np.roll(series.columns["quat_wxyz"][first], -1, axis=1))
            gap = self.gaps(series)[first, None]
            start = np.concatenate([series.columns["v_W"][first], R.apply(series.columns["w_B"][first]), gap], axis=1)
            since = series.t_s[rows[:, compared]] - series.t_s[first][:, None]
            out.append(np.concatenate([np.repeat(start, len(compared), axis=0), since.reshape(-1, 1)], axis=1))
        return out

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        if candidate.key not in self._biases:
            self._biases[candidate.key] = biases_of(candidate, self._simulated)
        return estimate(candidate, self._tosses(model, tuple(trials)), self._biases[candidate.key])

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: reading noise twice, the start's velocity noise carried along, and numerics.

        Numerics: what steps four times finer change. Nothing smaller than that is physics.
        """
        noise, length = self.measurement.noise, self.horizon_s
        p, turn = noise.p_m or 1e-4, noise.rotation_rad or 1e-3
        v = noise.v_mps or p / self._step_s
        w = noise.w_radps or turn / self._step_s
        position = 2.0 * p**2 + (v * length) ** 2 / 3.0
        rotation = 2.0 * turn**2 + (w * length) ** 2 / 3.0
        few = tuple(trials)[:_FEW]
        if (few, view) not in self._numeric:
            usual, fine = (np.concatenate(self._errors((), few, view, finer)) for finer in (1.0, _FINER))
            self._numeric[few, view] = ((fine - usual) ** 2).mean(axis=0)
        return np.sqrt(np.array([position] * 3 + [rotation] * 3) + self._numeric[few, view])

    @cached_property
    def _simulated(self) -> list[list[Toss]]:
        """Full roll-outs of the declared model from the first rows of training trials, at two step sizes."""
        few = split_trials(self.measurement.spec, self.trial_ids).train[:_FEW]
        declared = apply_terms(self.declared, ())
        return [
            [Toss(declared, moved(self._engine, declared, self._series[t], finer)) for t in few]
            for finer in (1.0, _FINER)
        ]

    def repeated(self, model: Model, seed: int) -> FreeBodyProblem:
        """See `simgap.numerics.Repeatable`; in finer steps, so that their error shows."""
        here = self.measurement
        trials = repeated(
            self._engine,
            apply_terms(self.declared, model),
            here.trials,
            [self._series[t.id] for t in here.trials],
            here.noise,
            _FINER,
            seed,
        )
        return FreeBodyProblem(replace(here, trials=trials), self._engine, self.horizon_s)

    def gaps(self, series: Series) -> FloatArray:
        """(n,) distance of the lowest point of the declared shapes from the support; negative is penetration."""
        body = self.declared
        R = Rotation.from_quat(np.roll(series.columns["quat_wxyz"], -1, axis=1)).as_matrix()
        level = Rotation.align_vectors([[0.0, 0.0, 1.0]], [body.plane_normal_W])[0].as_matrix()
        origins = series.columns["p"] @ level.T - np.array([0.0, 0.0, body.plane_height_m])
        return heights(body.shapes, origins, level @ R)

    def _tosses(self, model: Model, trials: tuple[str, ...]) -> list[Toss]:
        """Trials as they truly are under the model; those of the last call are kept."""
        asked = (tuple((t.candidate.key, tuple(t.values.items())) for t in model), trials)
        if self._read[0] != asked:
            applied = apply_terms(self.declared, model)
            self._read = (asked, [Toss(applied, applied.recovered(self._series[t])) for t in trials])
        return self._read[1]

    def _cut(self, trial: str, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Rows (w, k) of the windows of a trial, and the positions in a window that are compared."""
        length = len(self._series[trial].t_s)
        if view == "full_rollout" or self._rows >= length:
            return np.arange(length)[None], np.arange(1, length)
        k = self._rows
        compared = np.unique(np.linspace(1, k - 1, _COMPARED).round().astype(int))
        return self._starts[trial][:, None] + np.arange(k), compared

    @cached_property
    def _starts(self) -> dict[str, np.ndarray]:
        """First rows of the short windows of each trial."""
        return {trial: self._windows(series) for trial, series in self._series.items()}

    def _windows(self, series: Series) -> np.ndarray:
        """First rows of windows side by side: a few in flight and at rest, most where something is met."""
        k, p = self._rows, series.columns["p"]
        starts = np.arange(0, len(p) - k + 1, k - 1)
        rows = starts[:, None] + np.arange(k)
        flying = np.ones(len(starts), dtype=bool)
        resting = np.ptp(p[rows], axis=1).max(axis=1) < _MOVED * self._size
        if self.declared.has_support:
            flying = self.gaps(series)[rows].min(axis=1) > _CLEAR * self._size
        kinds = ((flying, _IN_FLIGHT), (~flying & resting, _AT_REST), (~flying & ~resting, _IN_CONTACT))
        return np.sort(np.concatenate([_spread(starts[of], most) for of, most in kinds]))

    @cached_property
    def _size(self) -> float:
        return float(np.ptp(corners(self.declared.shapes), axis=0).max())


def _spread(items: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the items, evenly."""
    return items[np.unique(np.linspace(0, len(items) - 1, min(most, len(items))).round().astype(int))]


def _reported(
    applied: AppliedBody, t_s: FloatArray, p: FloatArray, quat_wxyz: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Poses p (w, k, 3), quat_wxyz (w, k, 4) as the sensor reports them; what it does to poses it does row by row."""
    if not applied.sensors:
        return p, quat_wxyz
    rows = Series(t_s.ravel(), {"p": p.reshape(-1, 3), "quat_wxyz": quat_wxyz.reshape(-1, 4)})
    said = applied.reported(rows).columns
    return said["p"].reshape(p.shape), said["quat_wxyz"].reshape(quat_wxyz.shape)


def _errors(p: FloatArray, quat_wxyz: FloatArray, measured_p: FloatArray, measured_quat: FloatArray) -> FloatArray:
    """(w * c, 6) simulated minus measured; rotation as a vector in world axes."""
    position = np.clip(p - measured_p, -_LARGEST_M, _LARGEST_M).reshape(-1, 3)
    simulated = Rotation.from_quat(np.roll(quat_wxyz.reshape(-1, 4), -1, axis=1))
    truth = Rotation.from_quat(np.roll(measured_quat.reshape(-1, 4), -1, axis=1))
    return np.concatenate([position, (simulated * truth.inv()).as_rotvec()], axis=1)


def _series(trial: Trial) -> Series:
    """Pose and rates of a trial; rates that were not measured are central differences of the poses."""
    quats = trial.quat_wxyz
    v = trial.v_W if trial.has("v_W") else np.gradient(trial.p, trial.t_s, axis=0)
    w = trial.w_B if trial.has("w_B") else _rates(trial.t_s, quats)
    return Series(trial.t_s, {"p": trial.p, "quat_wxyz": quats, "v_W": v, "w_B": w})


def _rates(t_s: FloatArray, quat_wxyz: FloatArray) -> FloatArray:
    """(n, 3) body rates from orientations, central differences."""
    R = Rotation.from_quat(np.roll(quat_wxyz, -1, axis=1))
    between = (R[:-1].inv() * R[1:]).as_rotvec() / np.diff(t_s)[:, None]
    return np.concatenate([between[:1], 0.5 * (between[:-1] + between[1:]), between[-1:]])
