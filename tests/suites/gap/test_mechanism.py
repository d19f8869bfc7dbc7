"""The suite's rule, its truth generators against closed forms and each other, and a few cases end to end.

The whole suite is `make gap-suite`.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from sim.effects.library import EFFECT_NAMES
from simgap.find_gap import find_effects
from simgap.inference.agreement import agree, with_fixed_shape
from simgap.kinds.mechanism.equation_error import smooth_means
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.problem import Term
from simgap.recording.train_test_split import split_trials
from tests.suites.gap import mujoco_truth, truth
from tests.suites.gap.effects import EFFECTS
from tests.suites.gap.mechanism_cases import family_of, mechanism_case, single_case
from tests.suites.gap.run import run_case
from tests.suites.gap.table import _risk_over_coverage, table
from tests.suites.gap.truth import Plant

ROW_S = 5e-3


def _pendulum(drive: str = "none") -> Plant:
    return Plant(drive, False, np.array([0.02]), np.array([0.8]), np.array([0.1]))


def _released(plant: Plant, hidden: dict, rows: int = 300, start: float = 1.0) -> np.ndarray:
    joints = len(plant.inertia)
    inputs, at = np.zeros((1, rows, joints)), np.full((1, joints), start)
    return truth.simulate(plant, hidden, inputs, at, ROW_S, np.full((1, rows), 12.0))[0]


def test_small_swings_have_the_period_of_the_closed_form():
    q = _released(_pendulum(), {}, start=0.02)[:, 0]
    rate = np.sqrt(0.8 * 9.81 * 0.1 / 0.02)
    assert q == pytest.approx(0.02 * np.cos(rate * np.arange(len(q)) * truth.STEP_S), abs=1e-4)


def test_dry_friction_takes_an_equal_step_off_every_small_swing():
    friction = 0.005
    q = _released(_pendulum(), {"coulomb": np.array([friction])}, rows=600, start=0.15)[:, 0]
    peaks = np.abs(q[1:-1][(np.diff(q)[:-1] * np.diff(q)[1:]) < 0.0])
    assert -np.diff(peaks[:6]) == pytest.approx(2.0 * friction / (0.8 * 9.81 * 0.1), rel=0.1)


@pytest.mark.parametrize("hidden", [{}, {"viscous": 0.01}, {"spring": 0.3, "rest": 0.2}, {"coulomb": 0.02}])
def test_both_engines_make_the_same_motion(hidden):
    length = np.array([0.3, 0.25])
    mass = np.array([0.5, 0.3])
    chain = Plant("none", False, mass * length**2 * 0.4, mass, 0.5 * length, 0.3)
    numbers = {n: np.array([v, 0.0]) for n, v in hidden.items()}
    start = np.array([[0.9, -0.5]])
    theirs = mujoco_truth.simulate(chain, numbers, np.zeros((1, 100, 2)), start, ROW_S)[0]
    mine = truth.simulate(chain, numbers, np.zeros((1, 100, 2)), start, ROW_S, np.full((1, 100), 12.0))[0]
    assert np.abs(mine - theirs).max() < 0.02


def test_the_rule_gives_what_the_protocol_asks():
    families = Counter(family_of(k) for k in range(300))
    assert families["control"] >= 0.3 * 300
    assert families["two"] + families["outside"] >= 0.2 * 300
    assert len({e.name for e in EFFECTS}) >= 20
    assert {e.name for e in EFFECTS} | {n for e in EFFECTS for d in e.scenes.values() for n in d} <= set(EFFECT_NAMES)


def test_a_fast_clock_is_an_inertia_where_efforts_are_held_from_row_to_row():
    """Why the suite counts the two as doubles on a driven joint."""
    fast = 1.1
    inputs = 0.3 * np.random.default_rng(0).normal(size=(1, 200, 1))
    supply = np.full((1, 200), 12.0)
    plant = _pendulum("effort")
    q = truth.simulate(plant, {}, inputs, np.zeros((1, 1)), ROW_S, supply)[0, :: round(ROW_S / truth.STEP_S)]
    heavy = {"inertia_share": np.array([fast**2 - 1.0])}
    slow = truth.simulate(plant, heavy, inputs, np.zeros((1, 1)), fast * ROW_S, supply)[0]
    assert slow[:: round(fast * ROW_S / truth.STEP_S)] == pytest.approx(q, abs=0.01 * np.ptp(q))


def test_longer_means_of_the_balance_lose_noise_with_the_fifth_power_of_the_length():
    noise = np.random.default_rng(0).normal(size=20_002)
    accelerations = np.diff(noise, 2)
    spread = []
    for rows in (20, 40, 80):
        means = smooth_means(len(accelerations), rows)
        assert np.asarray(means.sum(axis=1)) == pytest.approx(1.0)
        spread.append((means @ accelerations).var())
    assert np.array(spread[:-1]) / spread[1:] == pytest.approx(32.0, rel=0.3)


def test_controls_stay_without_a_name():
    for number in (0, 3):
        record = run_case(mechanism_case(number))
        assert record["outcome"] == "silent", record["said"]


def test_an_effect_of_large_size_is_named_and_the_table_says_so():
    record = run_case(single_case(68, "joint.viscous_friction", "swing", "large"))
    assert record["size"] == "large"
    assert record["outcome"] == "named", record["said"]
    assert "| named, large | >= 85 % | 1/1 = 100%" in table([record])
    assert "| first name is right, sure or not, large | (beside) | 1/1 = 100%" in table([record])


def test_risk_over_coverage_counts_names_of_controls_as_wrong():
    def record(first: str, confidence: float, *truth: str) -> dict:
        return {"family": "control", "first": first, "confidence": confidence, "truth": list(truth)}

    records = [record("a@x", 0.9, "a@x"), record("b@x", 0.5), record("", 0.0), record("c@None", 0.7, "c")]
    assert _risk_over_coverage(records) == "0.111 of 3"  # nothing wrong among one and two, a third among three


def test_the_same_measurement_gives_the_same_selection():
    reports = []
    for _ in range(2):
        case = mechanism_case(0)
        problem = case.problem()
        trials = split_trials(case.spec, problem.trial_ids)
        reports.append(find_effects(problem, trials, measurement="made up", horizon_s=0.2, quick=True).report)
    assert reports[0] == reports[1]


def test_a_sensor_scale_cannot_shrink_the_error_away():
    """Half the scale halves every error in truth; as read nothing is gained."""
    problem = mechanism_case(0).problem()
    assert isinstance(problem, MechanismProblem)
    scale = next(c for c in problem.candidates() if c.effect.name == "sensor.scale")
    estimate = problem.direct(scale, (), problem.trial_ids)
    assert estimate is None or estimate.p_value > 1e-3 or abs(estimate.values["factor"] - 1.0) < 0.05


@pytest.mark.parametrize(("scene", "number"), [("servo", 1314), ("driven", 1323)])
def test_the_noise_of_a_start_counts_as_far_as_the_mechanism_carries_it(scene: str, number: int):
    """A controller forgets a start within a roll-out: all that is left to hear is the noise of the readings."""
    problem = mechanism_case(number).problem()
    assert isinstance(problem, MechanismProblem)
    assert (problem.declared.drive.type == "position_pd") is (scene == "servo")
    short, long = (problem.noise_floor(problem.trial_ids, view)[0] for view in ("short_horizon", "full_rollout"))
    assert bool(long < 0.9 * short) is (scene == "servo")


def test_strengths_of_two_routes_are_compared_at_one_shape():
    """Torque and speed of Stribeck friction trade against one another: apart by three times, yet one curve."""
    problem = single_case(1048, "joint.stribeck_friction", "slide", "large", 1.0).problem()
    rubbing = next(c for c in problem.candidates() if c.effect.name == "joint.stribeck_friction")
    rolled_out = Term(rubbing, {"torque_Nm": 15.5, "velocity_radps": 0.272})
    freely, pinned = (problem.direct(c, (), problem.trial_ids) for c in (rubbing, with_fixed_shape(rolled_out)))
    assert freely is not None
    assert pinned is not None
    assert freely.values["torque_Nm"] > 3.0 * rolled_out.values["torque_Nm"]
    assert not agree(rolled_out, {}, freely).kept
    assert agree(rolled_out, {}, pinned).kept


def test_a_lag_that_a_delay_mimics_gets_no_sure_name():
    record = run_case(single_case(1230, "actuator.lag", "driven", "large"))
    assert record["outcome"] not in ("wrong", "invented", "overconfident"), record["said"]


def test_a_stop_that_four_trials_of_sixteen_meet_is_named():
    record = run_case(single_case(2265, "joint.hard_stop", "slide", "middle", 3.0))
    assert record["outcome"] == "named", record["said"]
    assert record["covered"] == [True]
