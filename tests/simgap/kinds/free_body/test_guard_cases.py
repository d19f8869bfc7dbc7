"""Whole searches on a few tosses that guard the design: `tests.simgap.mutations` breaks it, and these must notice."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from schemas.sim_gap.report import GapReport
from sim.bullet.body import BulletBodyRollout
from simgap.find_gap import find_effects
from simgap.inference.verdict_text import NAMED
from simgap.kinds.free_body.declared_model import build_body
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.kinds.free_body.rigid import RigidBodySimulator
from simgap.recording.train_test_split import split_trials
from tests.suites.gap.free_body_cases import measured, spec_of
from tests.suites.gap.free_body_truth import Box, toss

EDGES_M = np.array([0.11, 0.08, 0.095])
BOX = Box(EDGES_M, float(800.0 * EDGES_M.prod()), 0.4)
WEIGHT_N = 9.81 * BOX.mass


@cache
def answer(judged_elsewhere: bool = False, count: int = 8, rate_hz: float = 120.0, **hidden: float) -> GapReport:
    """Of so many tosses in MuJoCo; `judged_elsewhere`: those that judge hide nothing."""
    spec, names = spec_of(BOX), tuple(f"t{k:02d}" for k in range(count))
    judges = split_trials(spec, names).test if judged_elsewhere else ()
    absent: Mapping[str, float] = {}
    row_s, step_s = 1.0 / rate_hz, min(1e-3, 0.125 / rate_hz)
    tosses = [
        toss(BOX, absent if name in judges else hidden, np.random.default_rng(k), 1.0, step_s, row_s)
        for k, name in enumerate(names)
    ]
    measurement = measured(spec, tosses)
    problem = FreeBodyProblem(measurement, RigidBodySimulator(build_body(spec, Path(".")), BulletBodyRollout()))
    trials = split_trials(spec, problem.trial_ids)
    return find_effects(problem, trials, measurement="m", horizon_s=problem.horizon_s, quick=True).report


def sure(report: GapReport) -> list[str]:
    return [e.name for e in report.verdict.effects if e.confidence >= NAMED]


def test_a_fall_that_is_too_slow_may_be_gravity_or_the_clock():
    """A pair: neither is sure, both are listed."""
    report = answer(g=7.5)
    assert sure(report) == []
    assert report.verdict.status == "ambiguous"
    assert any(
        {"world.gravity_magnitude", "sensor.clock_skew"} <= set(g.effects) for g in report.verdict.ambiguous_groups
    )


def test_a_force_across_spin_and_path_gets_no_name():
    """Outside the library."""
    report = answer(magnus=0.3 * WEIGHT_N)
    assert sure(report) == []


def test_nothing_hidden_gets_no_name():
    assert sure(answer()) == []


def test_what_judging_trials_do_not_show_is_no_effect():
    """Slippery where the model learns, as declared where it is judged."""
    assert answer(judged_elsewhere=True, mu=0.12).verdict.effects == ()


@pytest.mark.long
def test_a_fit_that_no_direct_estimate_bears_out_stays_in_doubt():
    """A grippy box hardly slides: friction is right, and not sure."""
    report = answer(mu=0.8)
    assert sure(report) == []
    assert ("contact.friction",) in [g.effects for g in report.verdict.ambiguous_groups]


def test_friction_at_500_hz_is_sure_and_its_interval_holds_the_truth():
    """At this rate the name was lost while slides and impacts were read over rows, not over times."""
    report = answer(rate_hz=500.0, mu=0.12)
    assert sure(report) == ["contact.friction"]
    (effect,) = report.verdict.effects
    low, high = effect.parameters["mu"].ci95
    assert low <= 0.12 <= high
