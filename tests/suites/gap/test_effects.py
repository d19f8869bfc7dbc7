"""Every hidden effect against the library: its log makes the effect a candidate, and both laws give the same motion."""

from __future__ import annotations

import numpy as np
import pytest

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import SensorMap, Series
from sim.dynamics.mechanism import Law, Windows, rollout
from sim.effects.library import effect
from tests.suites.gap.effects import EFFECTS, HiddenEffect
from tests.suites.gap.mechanism_cases import ROW_S, Stage
from tests.suites.gap.truth import STEP_S

NUMBER = 7
ROWS = 120


def _id(hidden: HiddenEffect) -> str:
    return f"{hidden.name} in {next(iter(hidden.scenes))}"


@pytest.mark.parametrize("hidden", [e for e in EFFECTS if e.checked is not None], ids=_id)
def test_a_log_makes_the_effect_a_candidate_whose_bounds_hold_the_truth(hidden: HiddenEffect):
    stage = Stage(NUMBER, next(iter(hidden.scenes)), 1.0, hidden.declared_friction)
    assert hidden.checked is not None
    parameter, value = hidden.checked(hidden.guess, stage.sizes)
    problem = stage.problem(stage.numbers(hidden, hidden.guess))
    mine = [c for c in problem.candidates() if c.effect.name == hidden.name]
    assert mine
    low, high = mine[0].bounds[parameter]
    assert low < value < high
    assert low <= mine[0].null[parameter] <= high
    assert mine[0].null[parameter] != value


@pytest.mark.parametrize(
    "hidden", [e for e in EFFECTS if e.torque is not None and len(effect(e.name).parameters) == 1], ids=_id
)
def test_both_laws_give_the_same_motion(hidden: HiddenEffect):
    """The suite's law, written from the physics, and the library's hook, in the suite's and in our integrator."""
    stage = Stage(NUMBER, next(iter(hidden.scenes)), 1.0)
    assert hidden.checked is not None
    parameter, value = hidden.checked(hidden.guess, stage.sizes)
    every = round(ROW_S / STEP_S)
    theirs = stage.motion(stage.numbers(hidden, hidden.guess))[:1, : ROWS * every : every]
    declared = stage.problem({}).declared
    t_s = np.arange(0.0, ROWS * ROW_S - 1e-9, ROW_S)[None]
    inputs = stage.inputs[:1, :ROWS]
    windows = Windows(t_s, stage.start[:1], np.zeros_like(stage.start[:1]), command=inputs, effort=inputs)
    laws = (Law(effect(hidden.name).hook, {parameter: value}, stage.joint),)
    with_law, without = (rollout(declared, windows, some, largest_step_s=STEP_S)[0] for some in (laws, ()))
    does = np.abs(with_law - without).max()
    assert does > 0.0
    assert np.abs(with_law - theirs).max() < 0.1 * does


def test_a_low_pass_of_the_log_is_the_librarys():
    """Readings of a sensor with a lag, and the library's map of the true motion."""
    stage = Stage(NUMBER, "slide", noise=0.0)
    seen, plain = (stage.problem(numbers).measurement.trials[0] for numbers in ({"sensor_lag_s": 0.05}, {}))
    hook = effect("sensor.lag").hook
    assert isinstance(hook, SensorMap)
    reported = hook.report(Series(plain.t_s, {"q": plain.q}), {"time_constant_s": 0.05}, Place())
    assert np.abs(seen.q - plain.q).max() > 0.05 * np.ptp(plain.q)
    np.testing.assert_allclose(reported.columns["q"], seen.q, atol=2e-3 * np.ptp(plain.q))
