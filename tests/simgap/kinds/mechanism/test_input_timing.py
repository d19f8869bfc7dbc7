"""When inputs act: at stamps, or at an even beat that the stamps only blur; what is known of lost rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from schemas.measurement import MeasurementSpec
from sim.dynamics.mechanism import rollout
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.input_timing import even_stamps, possible_timings, with_timing
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.mechanism.windows import cut, windows_of
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial

ROW_S, ROWS = 5e-3, 400


def _trial(name: str, t_s: np.ndarray, command: np.ndarray, q: np.ndarray | None = None) -> Trial:
    n = len(t_s)
    absent: dict[str, Any] = {
        k: np.full((n, w), np.nan) for k, w in (("p", 3), ("quat_wxyz", 4), ("v_W", 3), ("w_B", 3))
    }
    absent |= {"command_p": absent["p"], "command_quat_wxyz": absent["quat_wxyz"]}
    absent |= {k: np.full((n, 1), np.nan) for k in ("qd", "effort")}
    return Trial(id=name, t_s=t_s, q=np.zeros((n, 1)) if q is None else q, command=command, aux={}, **absent)


def test_rows_without_gaps_keep_their_inputs():
    trial = _trial("t", np.arange(20) * ROW_S, np.random.default_rng(0).normal(size=(20, 1)))
    np.testing.assert_array_equal(with_timing(trial, "stamps").command, trial.command)
    assert possible_timings(trial) == ("stamps",)


@settings(max_examples=50, deadline=None)
@given(lost=st.integers(1, 4), place=st.integers(1, 10), slope=st.floats(-5.0, 5.0))
def test_the_impulse_of_lost_rows_is_that_of_a_ramp(lost: int, place: int, slope: float):
    """A ramp sampled and held has the same mean over a gap whether its rows were logged or not."""
    t_s = np.arange(20) * ROW_S
    ramp = slope * t_s[:, None]
    kept = np.ones(20, dtype=bool)
    kept[place : place + lost] = False
    seen = with_timing(_trial("t", t_s[kept], ramp[kept]), "stamps").command
    assert seen[place - 1, 0] == pytest.approx(ramp[place - 1 : place + lost, 0].mean(), abs=1e-9)
    np.testing.assert_allclose(np.delete(seen, place - 1, axis=0), np.delete(ramp[kept], place - 1, axis=0), atol=1e-9)


def test_a_step_in_a_gap_is_split_between_the_two_times_it_may_have_come():
    command = np.array([0.0, 0.0, 1.0, 1.0])[:, None]
    seen = with_timing(_trial("t", np.array([0.0, 1.0, 3.0, 4.0]), command), "stamps").command
    np.testing.assert_allclose(seen[:, 0], [0.0, 0.25, 1.0, 1.0])


def test_a_long_pause_is_no_row_that_was_lost():
    command = np.array([0.0, 1.0, 2.0, 3.0])[:, None]
    seen = with_timing(_trial("t", np.array([0.0, 1.0, 2.0, 50.0]), command), "stamps").command
    np.testing.assert_allclose(seen, command)


def test_an_even_beat_is_found_beneath_jitter_and_gaps():
    rng = np.random.default_rng(3)
    timing = 2.0 + np.arange(400) * ROW_S
    stamps = (timing + rng.normal(0.0, 0.03 * ROW_S, 400))[rng.random(400) > 0.02]
    even = even_stamps(stamps)
    assert even is not None
    np.testing.assert_allclose(np.diff(even) / ROW_S, np.round(np.diff(even) / ROW_S), atol=1e-3)
    assert np.abs(even - stamps).max() < 0.15 * ROW_S


def test_stamps_that_follow_no_beat_are_left_alone():
    t_s = np.cumsum(np.random.default_rng(1).uniform(0.2, 1.8, 300)) * ROW_S
    assert possible_timings(_trial("t", t_s, np.zeros((300, 1)))) == ("stamps",)


def _servo(late_loop: bool, late_reading: bool) -> MechanismProblem:
    """A servo whose stamps jitter: `late_loop`: it sends when they say; `late_reading`: it reads when they say."""
    spec = MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "servo",
            "kind": "mechanism",
            "columns": {"t": "t", "q_axis": "q_axis", "command_axis": "command_axis"},
            "subject": {"joints": [{"name": "axis", "type": "revolute", "inertia_kgm2": 0.01}]},
            "actuation": {"type": "position_pd", "kp": 12.0, "kd": 0.5},
        }
    )
    rng = np.random.default_rng(5)
    fine = 20
    clock = np.arange(ROWS * fine) * ROW_S / fine
    trials, moved = [], []
    for k in range(8):
        timing = np.arange(ROWS) * ROW_S
        stamps = np.clip(timing + rng.normal(0.0, 0.05, ROWS) * ROW_S, 0.0, None)
        waves = rng.uniform((0.1, 4.0, 0.0), (0.4, 15.0, 6.0), (4, 3))
        command = np.sum([a * np.sin(w * timing + p) for a, w, p in waves], axis=0)
        sent_at = stamps if late_loop else timing
        held = command[np.clip(np.searchsorted(sent_at, clock, side="right") - 1, 0, ROWS - 1)]
        trials.append((f"t{k}", stamps, command[:, None]))
        moved.append((sent_at, stamps if late_reading else timing, held))
    plain = [_trial(f"t{k}", clock, held[:, None]) for k, (_, _, held) in enumerate(moved)]
    still = MechanismProblem(Measurement(spec, tuple(plain), Path("."), "servo", ("axis",)))
    applied = apply_terms(still.declared, ())
    series = [still.logs.by_trial[t.id].series for t in plain]
    windows = windows_of([(s, cut(len(s.t_s), None)) for s in series], applied)
    q, _ = rollout(still.declared, windows, largest_step_s=2.5e-4)
    read = [
        np.interp(read_at, s.t_s, q[k, : len(s.t_s), 0])[:, None] + rng.normal(0.0, 1e-4, (ROWS, 1))
        for k, (s, (_, read_at, _)) in enumerate(zip(series, moved, strict=True))
    ]
    logged = [_trial(*given, q=q_read) for given, q_read in zip(trials, read, strict=True)]
    return MechanismProblem(Measurement(spec, tuple(logged), Path("."), "servo", ("axis",)))


@pytest.mark.parametrize(
    ("late_loop", "late_reading", "timing"),
    [(True, True, "stamps"), (False, True, "even_inputs"), (False, False, "even")],
)
def test_the_motion_tells_when_inputs_act_and_readings_were_taken(late_loop: bool, late_reading: bool, timing: str):
    found = _servo(late_loop, late_reading).with_input_timing()
    assert found.timing == timing
    timing_check = found.timing_check()
    assert timing_check is not None
    assert timing_check.status == ("ok" if timing == "stamps" else "fixed")
    assert "0.25 ms" in timing_check.evidence


def test_inputs_that_no_motion_hears_of_leave_the_stamps():
    """Half the readings replaced by noise: no timing is better, nothing is changed."""
    problem = _servo(True, True)
    rng = np.random.default_rng(2)
    trials = tuple(replace(t, q=rng.normal(size=t.q.shape)) for t in problem.measurement.trials)
    found = MechanismProblem(replace(problem.measurement, trials=trials)).with_input_timing()
    assert found.timing == "stamps"


def test_one_late_stamp_is_no_lost_row():
    t_s = np.array([0.0, 0.01, 0.026, 0.03, 0.04, 0.05])
    command = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])[:, None]
    np.testing.assert_array_equal(with_timing(_trial("t", t_s, command), "stamps").command, command)


@pytest.mark.parametrize("t_s", [[0.0], [0.0, 0.1], [0.0, 0.0, 0.0, 0.01], [0.0, 0.02, 0.01, 0.03]])
def test_stamps_without_a_beat_are_left_alone(t_s: list[float]):
    trial = _trial("t", np.array(t_s), np.arange(len(t_s), dtype=float)[:, None])
    assert possible_timings(trial) == ("stamps",)
    np.testing.assert_array_equal(with_timing(trial, "stamps").command, trial.command)


def test_beats_that_cut_trials_differently_are_compared_too():
    """At 500 Hz rows are thinned by the median step, which jitter moves across a whole number: pieces differ."""
    rng = np.random.default_rng(2)
    spec = _servo(True, True).measurement.spec
    trials = []
    for k in range(2):
        timing = np.arange(1000) * 2e-3
        stamps = np.clip(timing + rng.normal(0.0, 0.05, 1000) * 2e-3, 0.0, None)
        command = 0.3 * np.sin(9.0 * timing + k)[:, None]
        trials.append(_trial(f"t{k}", np.maximum.accumulate(stamps), command, command + rng.normal(0, 1e-4, (1000, 1))))
    for some in (trials, [replace(t, t_s=t.t_s * 1.0007) for t in trials]):
        problem = MechanismProblem(Measurement(spec, tuple(some), Path("."), "servo", ("axis",)))
        found = problem.with_input_timing()
        assert len(found.residuals((), found.trial_ids, "short_horizon")) == 2
