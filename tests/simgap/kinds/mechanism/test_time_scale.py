"""The time scale of a recording follows its own motion: no number of it is a time in seconds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from schemas.arrays import FloatArray
from schemas.measurement import MeasurementSpec
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.mechanism.time_scale import TimeScale, time_scale
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial

RATE_HZ, SPAN_S, NOISE_RAD, TRIALS = 200.0, 4.0, 3e-4, 5
SLOW_RADPS, FAST_RADPS = 2.0, 5.0


@dataclass(frozen=True)
class Law:
    """Factors of lengths and times, rows per row of the plain log, order of the joints, epoch (s)."""

    length: float = 1.0
    time: float = 1.0
    rows: float = 1.0
    joints: tuple[int, ...] = (0, 1)
    epoch_s: float = 0.0


def _trial(name: str, t_s: FloatArray, q: FloatArray) -> Trial:
    def absent(columns: int) -> FloatArray:
        return np.full((len(t_s), columns), np.nan)

    return Trial(
        id=name,
        t_s=t_s,
        q=q,
        p=absent(3),
        quat_wxyz=absent(4),
        v_W=absent(3),
        w_B=absent(3),
        command_p=absent(3),
        command_quat_wxyz=absent(4),
        qd=absent(q.shape[1]),
        effort=absent(q.shape[1]),
        command=absent(q.shape[1]),
    )


def swings(law: Law = Law()) -> tuple[Trial, ...]:
    """Two joints that swing at different rates, read with noise; the readings of equal instants differ by noise."""
    out = []
    for k in range(TRIALS):
        rng = np.random.default_rng(k)
        t_s = np.arange(round(SPAN_S * RATE_HZ * law.rows)) / (RATE_HZ * law.rows)
        phase = rng.uniform(0.0, 6.0, 2)
        q = np.stack([np.sin(SLOW_RADPS * t_s + phase[0]), 0.4 * np.sin(FAST_RADPS * t_s + phase[1])], axis=1)
        q += rng.normal(0.0, NOISE_RAD, q.shape)
        out.append(_trial(f"t{k}", law.time * t_s + law.epoch_s, law.length * q[:, law.joints]))
    return tuple(out)


def problem_of(law: Law) -> MechanismProblem:
    spec = MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "swing",
            "kind": "mechanism",
            "columns": {"t": "t", "q_a": "a", "q_b": "b"},
            "subject": {"joints": [{"name": n, "inertia_kgm2": 1.0} for n in "ab"]},
            "actuation": {"type": "none"},
            "world": {"gravity_mps2": [0, 0, -9.81]},
        }
    )
    return MechanismProblem(Measurement(spec, swings(law), Path("."), "swing", ("a", "b")))


def test_a_radian_is_that_of_the_fastest_joint_and_a_cubic_spans_a_quarter_of_it():
    scale = time_scale(swings())
    assert scale.radian_s == pytest.approx(1.0 / FAST_RADPS, rel=0.03)
    assert scale.span_s == pytest.approx(0.25 / FAST_RADPS, rel=0.05)


LAWS = {
    "lengths times 10": Law(length=10.0),
    "lengths times 1e-3": Law(length=1e-3),
    "time times 10": Law(time=10.0),
    "time times 1e-2": Law(time=1e-2),
    "half the rows": Law(rows=0.5),
    "four times the rows": Law(rows=4.0),
    "joints permuted": Law(joints=(1, 0)),
    "another epoch": Law(epoch_s=1.7e9),
}


@pytest.mark.parametrize("law", [pytest.param(law, id=name) for name, law in LAWS.items()])
def test_scales_follow_the_time_of_the_log_and_nothing_else(law: Law):
    plain, scale = time_scale(swings()), time_scale(swings(law))
    # Stamps of another epoch are rounded to a quarter of a microsecond; other rows have other noise.
    assert scale.radian_s == pytest.approx(law.time * plain.radian_s, rel=0.02)
    assert scale.span_s == pytest.approx(law.time * plain.span_s, rel=0.02)


@pytest.mark.parametrize("time", [1.0, 30.0])
@pytest.mark.parametrize("rows", [1.0, 4.0])
def test_steps_horizon_windows_and_thinned_rows_follow_the_scale(time: float, rows: float):
    plain, problem = problem_of(Law()), problem_of(Law(time=time, rows=rows))
    assert problem.horizon_s == pytest.approx(time * plain.horizon_s, rel=0.02)
    assert problem.logs.step_s == pytest.approx(time * plain.logs.step_s, rel=0.02)
    for trial in problem.trial_ids:
        ours, before = (p.logs.cut(trial, "short_horizon").rows for p in (problem, plain))
        step_s = np.median(np.diff(problem.logs.by_trial[trial].series.t_s))
        # At 200 and 800 Hz the same rows are kept: what smoothing needs, whatever the log has.
        assert step_s == pytest.approx(time / RATE_HZ, rel=0.35)
        assert ours.shape[1] * step_s == pytest.approx(time * before.shape[1] / RATE_HZ, rel=0.15)


def test_a_joint_that_stands_has_no_say():
    still = [_trial(t.id, t.t_s, np.concatenate([t.q, np.full((len(t), 1), 0.3)], axis=1)) for t in swings()]
    assert time_scale(still) == time_scale(swings())


def test_a_joint_that_jumps_is_followed_at_its_jumps():
    """Moves of 0.1 s to and fro between rests of two seconds: slow on average."""
    t_s = np.arange(0.0, 8.4, 5e-3)
    ramp = np.clip((t_s % 4.2 - 1.0) / 0.1, 0.0, 1.0) - np.clip((t_s % 4.2 - 3.1) / 0.1, 0.0, 1.0)
    q = (ramp**2 * (3.0 - 2.0 * ramp))[:, None]
    q += np.random.default_rng(0).normal(0.0, NOISE_RAD, q.shape)
    scale = time_scale([_trial("a", t_s, q)])
    assert scale.radian_s > 0.15
    assert 0.005 < scale.span_s < 0.02


def test_a_joint_that_drifts_through_its_trial_has_shares_of_the_trial():
    """A fifth of a period: the motion alone would give a radian longer than half of the trial."""
    t_s = np.arange(0.0, 4.0, 5e-3)
    q = np.sin(0.3 * t_s)[:, None] + np.random.default_rng(0).normal(0.0, NOISE_RAD, (len(t_s), 1))
    scale = time_scale([_trial("a", t_s, q)])
    assert scale.radian_s == pytest.approx(t_s[-1] / 12.0)
    assert scale.span_s == pytest.approx(t_s[-1] / 48.0)


def test_rows_that_are_too_few_for_a_cubic_are_refused():
    with pytest.raises(ValueError, match="6 rows are too few"):
        time_scale([_trial("a", np.arange(6.0), np.zeros((6, 1)))])


def test_motion_that_never_shows_has_the_shortest_scale_that_its_rows_allow():
    assert time_scale([_trial("a", np.arange(50.0), np.zeros((50, 1)))]) == TimeScale(28.0, 7.0)
