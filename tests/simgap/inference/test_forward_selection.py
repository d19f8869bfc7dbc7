"""Forward selection keeps rivals, declared numbers and the count of trials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from schemas.arrays import FloatArray
from schemas.measurement import MeasurementSpec
from schemas.sim_gap.extension import Place
from schemas.sim_gap.report import Gain
from sim.effects.library import effect
from simgap.inference.candidate_fit import CandidateFit, candidate_fit_on, ranked_screening, warm_start_without
from simgap.inference.comparison import refitted_with_alternatives
from simgap.inference.fit import Errors, extend, fit, resampling_units
from simgap.inference.hypothesis import Accepted
from simgap.inference.losses import compare
from simgap.inference.parametric_bootstrap import MethodBias
from simgap.inference.search_state import SearchState
from simgap.problem import Candidate, DirectEstimate, Model
from simgap.recording.train_test_split import Trials, split_trials

TRIALS, ROWS = 12, 40
FRICTION = effect("joint.coulomb_friction")


def _cause(number: int, nuisance: bool = False) -> Candidate:
    bounds = (0.8, 1.2) if nuisance else (-10.0, 10.0)
    none = {"torque_Nm": 1.0 if nuisance else 0.0}
    return Candidate(FRICTION, Place(joint=f"axis{number}"), none, none, {"torque_Nm": bounds}, nuisance)


class _Columns:
    """Causes whose traces are the same column, with noise of their own: none of them can be distinguished."""

    def __init__(self, count: int, alike: float) -> None:
        rng = np.random.default_rng(4)
        shared, *own = rng.normal(0.0, 1.0, (count + 1, TRIALS, ROWS))
        self.traces = {_cause(k).key: shared + (1.0 - alike) * o for k, o in enumerate(own)}
        self.noise = rng.normal(0.0, 1.0, (TRIALS, ROWS))
        self.shared = shared

    def errors(self, model: Model) -> list[FloatArray]:
        predicted = self.noise - 2.0 * self.shared
        for term in model:
            predicted = predicted + term.values["torque_Nm"] * self.traces.get(term.candidate.key, 0.0)
        return list(predicted)

    def direct(self, candidate: Candidate, model: Model, trials: tuple[str, ...]) -> DirectEstimate | None:
        return None

    def nuisances(self) -> tuple[Candidate, ...]:
        return ()


def _search(count: int, alike: float) -> tuple[SearchState, Accepted, list[CandidateFit]]:
    columns = _Columns(count, alike)
    errors: Errors = columns.errors
    null = fit(errors, ())
    tried = [candidate_fit_on(null, extend(errors, null, _cause(k), [{"torque_Nm": 0.0}]), None) for k in range(count)]
    this = ranked_screening(tried)
    first, *others = this.fits
    accepted = Accepted(first, this, this.p_adjusted[0], tuple(others), MethodBias())
    trials = Trials(tuple(f"t{k}" for k in range(TRIALS)), ())
    here = SearchState(columns, trials, np.ones(1), errors, first.fit)  # pyright: ignore[reportArgumentType]
    return here, accepted, others


def test_rivals_that_there_is_no_time_to_ask_stay():
    here, found, others = _search(8, alike=0.999)
    assert len(others) == 7
    _, again, _ = refitted_with_alternatives(here, found, map)
    assert {r.candidate.key for r in again.rivals} == {t.candidate.key for t in others}


def test_a_rival_that_was_accepted_since_is_none_any_more():
    here, found, (rival, *others) = _search(3, alike=0.999)
    both = extend(here.errors, found.candidate_fit.fit, rival.candidate, [rival.candidate.start])
    _, again, _ = refitted_with_alternatives(replace(here, base=both), found, map)
    assert {r.candidate.key for r in again.rivals} <= {t.candidate.key for t in others}


def test_a_declared_number_comes_back_with_its_tolerance_when_an_effect_leaves():
    columns = _Columns(2, alike=0.0)
    twin, other = _cause(0, nuisance=True), _cause(1)
    base = fit(columns.errors, [twin, other])
    named = extend(columns.errors, base, _cause(0), [{"torque_Nm": 1.0}])
    assert [c.key for c in named.free] == [other.key, _cause(0).key]
    kept = warm_start_without(named, [_cause(0)], [twin])
    assert [c.key for c in kept] == [twin.key, other.key]
    assert kept[0].bounds == twin.bounds


def test_a_trial_of_one_row_is_one_cluster():
    rows = [np.full((1, 2), float(k)) for k in range(7)]
    assert [c.tolist() for c in resampling_units(rows)] == [[k, k] for k in range(7)]


@pytest.mark.parametrize(("count", "test"), [(2, 1), (3, 1), (4, 2), (5, 2), (10, 3), (60, 18)])
def test_two_trials_judge_wherever_two_are_left_to_teach(count: int, test: int):
    spec = MeasurementSpec.model_construct(split=None)
    trials = split_trials(spec, [f"t{k}" for k in range(count)])
    assert (len(trials.train), len(trials.test)) == (count - test, test)


def test_a_gain_on_one_trial_is_written_and_read_back():
    judged = compare(np.ones(1), np.full(1, 0.5))
    gain = Gain(
        view="short_horizon",
        horizon_s=0.2,
        metric="m",
        heldout_before=2.0,
        heldout_after=1.0,
        reduction=0.5,
        ci95=judged.ci95,
        noise_floor=1.0,
        gap_closed=0.5,
    )
    assert Gain.model_validate_json(gain.model_dump_json()) == gain
