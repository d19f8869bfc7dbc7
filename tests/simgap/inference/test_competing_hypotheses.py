"""Competing hypotheses and replacements among causes whose residuals are known columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from schemas.sim_gap.extension import Place
from schemas.sim_gap.report import Gain
from sim.effects.library import effect
from simgap.inference.agreement import agree
from simgap.inference.candidate_fit import CandidateFit, Screening, candidate_fit_on
from simgap.inference.competing_hypotheses import alternatives, as_good_with_confusable, is_as_good, replacement
from simgap.inference.fit import Errors, Fit, extend, fit
from simgap.inference.forward_selection import Selection
from simgap.inference.hypothesis import Accepted, Evidence, is_confirmed
from simgap.inference.intervals import differs_from_none, distance_to_alternatives, symmetric, wider
from simgap.inference.losses import Comparison, paired_p, paired_p_where_affected
from simgap.inference.parametric_bootstrap import MethodBias
from simgap.inference.verdict import judge
from simgap.problem import Candidate, DirectEstimate, Model, Term

TRIALS, ROWS = 12, 40
NAMES = {"joint.coulomb_friction": "torque_Nm", "joint.viscous_friction": "damping_Nms_per_rad"}
GAIN = Gain(
    view="short_horizon",
    horizon_s=0.2,
    metric="rms error in noise levels",
    heldout_before=4.0,
    heldout_after=2.0,
    reduction=0.5,
    ci95=(0.4, 0.6),
    noise_floor=1.0,
    gap_closed=0.7,
)
COULOMB, VISCOUS = (
    Candidate(effect(name), Place(joint="axis"), {p: 0.0}, {p: 0.0}, {p: (-10.0, 10.0)}) for name, p in NAMES.items()
)


def _columns(alike: float) -> dict[str, FloatArray]:
    """(t, n) unit traces of the two causes, alike by that much."""
    rng = np.random.default_rng(3)
    first, second = rng.normal(0.0, 1.0, (2, TRIALS, ROWS))
    return {COULOMB.key: first, VISCOUS.key: alike * first + np.sqrt(1.0 - alike**2) * second}


def _errors(columns: dict[str, FloatArray], truth: dict[str, float]) -> Errors:
    """What a model leaves of the true causes under noise of one level."""
    noise = np.random.default_rng(5).normal(0.0, 1.0, (TRIALS, ROWS))

    def errors(model: Model) -> list[FloatArray]:
        predicted = noise - sum(share * columns[key] for key, share in truth.items())
        for term in model:
            predicted = predicted + next(iter(term.values.values())) * columns[term.candidate.key]
        return list(predicted)

    return errors


def _tried(errors: Errors, base: Fit, candidate: Candidate) -> CandidateFit:
    return candidate_fit_on(base, extend(errors, base, candidate, [candidate.start]), None)


def _accepted_then_tried(truth: dict[str, float]) -> tuple[CandidateFit, CandidateFit]:
    """Coulomb friction on top of nothing, and viscous friction on top of that; their traces are alike by 0.9."""
    errors = _errors(_columns(0.9), truth)
    first = _tried(errors, fit(errors, ()), COULOMB)
    return first, _tried(errors, first.fit, VISCOUS)


def test_a_fit_at_the_end_of_a_range_is_as_sure_as_the_route_that_set_it():
    errors = _errors(_columns(0.0), {COULOMB.key: 3.0})
    wall = replace(COULOMB, bounds={"torque_Nm": (-1.0, 2.0)})
    alone, told = (fit(errors, [c]) for c in (wall, replace(wall, direct_half_width={"torque_Nm": 0.4})))
    assert alone.model[-1].values["torque_Nm"] == told.model[-1].values["torque_Nm"] == pytest.approx(2.0)
    assert alone.half_widths[wall.key]["torque_Nm"] == 0.0
    refusal = alone.strength_exceeds({})
    assert (refusal.kept, refusal.reason) == (False, Reason.BOUND_REACHED)
    assert told.half_widths[wall.key]["torque_Nm"] == pytest.approx(0.4)
    assert told.strength_exceeds({}).kept
    assert told.p_value == 1.0  # No test over trials: an end of a range is no agreement.
    free = fit(errors, [replace(COULOMB, direct_half_width={"torque_Nm": 0.4})])
    assert free.half_widths == fit(errors, [COULOMB]).half_widths


@pytest.mark.parametrize("known", [0.4, 0.3, 0.1, 0.7])
def test_a_fit_at_the_far_end_of_a_told_range_does_not_stand_out_by_rounding(known: float):
    none = 1.0
    errors = _errors(_columns(0.0), {COULOMB.key: -3.0})
    candidate = replace(
        COULOMB,
        null={"torque_Nm": none},
        start={"torque_Nm": none},
        bounds={"torque_Nm": (none - known, 2.0)},
        direct_half_width={"torque_Nm": known},
    )
    found = fit(errors, [candidate])
    assert found.model[-1].values["torque_Nm"] == pytest.approx(none - known)
    assert found.strength_exceeds({}).reason is Reason.INTERVAL_INCLUDES_NONE
    assert not differs_from_none(found.model[-1], symmetric(found.half_widths[candidate.key])).kept


def test_an_interval_of_a_fit_at_an_end_that_was_told_covers_what_tells_it():
    told = Term(replace(COULOMB, direct_half_width={"torque_Nm": 0.4}), {"torque_Nm": 2.0})
    assert distance_to_alternatives(told, {"torque_Nm": 0.4}, _direct_estimate(1.6, 0.1), [])[
        "torque_Nm"
    ] == pytest.approx((0.4 + 0.196, 0.0))


def test_what_makes_an_accepted_effect_vanish_is_tried_in_its_place():
    mimic, true = _accepted_then_tried({VISCOUS.key: 2.0})
    assert mimic.comparison.gain > 0.3
    assert replacement(Screening((true,), (1e-4,)), mimic.fit, [mimic]) == (0, true)


def test_what_stands_beside_an_accepted_effect_is_added():
    first, second = _accepted_then_tried({COULOMB.key: 2.0, VISCOUS.key: 2.0})
    assert replacement(Screening((second,), (1e-4,)), first.fit, [first]) is None


@pytest.mark.parametrize("p_adjusted", [0.2, 1.0])
def test_chance_takes_no_place(p_adjusted: float):
    mimic, true = _accepted_then_tried({VISCOUS.key: 2.0})
    assert replacement(Screening((true,), (p_adjusted,)), mimic.fit, [mimic]) is None


def test_only_doubles_and_what_left_little_more_is_asked_again():
    mimic, _ = _accepted_then_tried({VISCOUS.key: 4.0})
    errors = _errors(_columns(0.9), {VISCOUS.key: 4.0})
    other = _tried(errors, fit(errors, ()), VISCOUS)
    this = Screening((mimic, other), (1e-4, 1e-4))
    assert alternatives(mimic, this, (), mimic.fit) == [other]
    unjudged = replace(other, comparison=replace(other.comparison, gain=0.0))
    assert alternatives(mimic, replace(this, fits=(mimic, unjudged)), (), mimic.fit) == []
    assert alternatives(mimic, replace(this, fits=(mimic, unjudged)), (VISCOUS.key,), mimic.fit) == [unjudged]
    # A confusable cause is refitted even if it leaves far more than twice as much: beside another cause it may not.
    assert alternatives(other, this, (), other.fit) == [mimic]
    stranger = replace(mimic, candidate=replace(COULOMB, effect=effect("sensor.bias")))
    assert alternatives(other, replace(this, fits=(stranger, other)), (), other.fit) == []


def test_trials_that_stay_away_from_a_threshold_do_not_hide_what_it_does_to_the_others():
    rng = np.random.default_rng(1)
    before = np.exp(rng.normal(0.0, 0.1, 16))
    after = before * np.exp(rng.normal(0.0, 0.01, 16))
    before[[2, 5, 9, 11]] *= [90.0, 20.0, 150.0, 40.0]
    assert paired_p_where_affected(before, after) < 0.1 * paired_p(before, after)
    # Two trials are too few for any test, and a change for the worse is no evidence.
    few = after.copy()
    few[[2, 5]] = before[[2, 5]]
    assert paired_p_where_affected(before, few) == 1.0
    assert paired_p_where_affected(after, before) > 0.99


def test_what_changes_nothing_but_noise_is_named_by_chance_only():
    rng = np.random.default_rng(2)
    losses = np.exp(rng.normal(0.0, 0.3, (2, 2000, 16)))
    wrong = np.mean([paired_p_where_affected(a, b) < 0.05 for a, b in zip(*losses, strict=True)])
    assert wrong < 0.07


def test_one_violent_trial_does_not_hide_all_others():
    before = np.array([1e4, 2.0, 2.1, 2.0, 1.9, 2.0, 2.2, 1.8])
    assert paired_p_where_affected(before, np.ones(8)) < 0.1


def test_two_causes_that_stand_for_two_others_are_doubles_together():
    """Friction by load and a weight do what dry friction and a spring do; one of either kind in turn does not."""
    names = {"load": "joint.load_dependent_friction", "weight": "joint.gravity_load"}
    names |= {"dry": "joint.coulomb_friction", "spring": "joint.viscous_friction"}
    cause = {
        k: Candidate(effect(n), Place(joint="axis"), {"x": 0.0}, {"x": 0.0}, {"x": (-10.0, 10.0)})
        for k, n in names.items()
    }
    x, y, apart = np.random.default_rng(7).normal(0.0, 1.0, (3, TRIALS, ROWS))
    traces = {"load": x + 0.5 * apart, "weight": y - 0.5 * apart, "dry": x, "spring": y}
    columns = {cause[k].key: v for k, v in traces.items()}
    errors = _errors(columns, {cause["load"].key: 3.0, cause["weight"].key: 3.0})
    null = fit(errors, ())
    load, dry = (_tried(errors, null, cause[k]) for k in ("load", "dry"))
    weight, spring = (_tried(errors, load.fit, cause[k]) for k in ("weight", "spring"))
    assert is_as_good(spring, weight).reason is Reason.FITS_WORSE_THAN
    assert as_good_with_confusable(errors, weight.fit, (), load, [], weight, [spring]) == []
    ((found, decision),) = as_good_with_confusable(errors, weight.fit, (), load, [dry], weight, [spring])
    assert found.candidate.key == cause["spring"].key
    assert (decision.kept, decision.reason) == (True, Reason.INSEPARABLE_FROM)


@pytest.mark.parametrize(("p_adjusted", "sure"), [(1e-3, True), (0.5, False)])
def test_what_took_the_place_of_another_and_may_be_chance_has_no_sure_name(p_adjusted: float, sure: bool):
    class Told:
        def direct(self, candidate: Candidate, model: Model, trials: tuple[str, ...]) -> DirectEstimate:
            return DirectEstimate({"torque_Nm": 2.0}, {"torque_Nm": 0.05}, 1e-6, TRIALS)

    errors = _errors(_columns(0.0), {COULOMB.key: 2.0})
    null = fit(errors, ())
    found = replace(_tried(errors, null, COULOMB), direct=Told().direct(COULOMB, (), ()))
    accepted = Accepted(found, Screening((found,), (p_adjusted,)), p_adjusted, (), MethodBias())
    selection = Selection(null, null.losses, (accepted,), None, found.fit, found.fit.losses, np.ones(1))
    verdict = judge(Told(), selection, ("t0",), [GAIN], Comparison(0.0, (0.0, 0.0), 1.0)).verdict  # pyright: ignore[reportArgumentType]
    assert verdict.status == ("effect_found" if sure else "ambiguous")


@pytest.mark.parametrize(("error", "sure"), [(0.05, True), (1.5, False)])
def test_what_may_be_nothing_by_its_own_interval_has_no_sure_name(error: float, sure: bool):
    """The direct route agrees within a factor of two; its own error is part of the interval that is reported."""

    class Told:
        def direct(self, candidate: Candidate, model: Model, trials: tuple[str, ...]) -> DirectEstimate:
            return DirectEstimate({"torque_Nm": 1.4}, {"torque_Nm": error}, 1e-3, TRIALS)

    errors = _errors(_columns(0.0), {COULOMB.key: 2.0})
    null = fit(errors, ())
    said = Told().direct(COULOMB, (), ())
    found = replace(_tried(errors, null, COULOMB), direct=said)
    accepted = Accepted(found, Screening((found,), (1e-6,)), 1e-6, (), MethodBias())
    selection = Selection(null, null.losses, (accepted,), None, found.fit, found.fit.losses, np.ones(1))
    verdict = judge(Told(), selection, ("t0",), [GAIN], Comparison(0.0, (0.0, 0.0), 1.0)).verdict  # pyright: ignore[reportArgumentType]
    (low, high) = verdict.effects[0].parameters["torque_Nm"].ci95
    assert (verdict.status == "effect_found") == sure
    assert (low > 0.0) == sure
    assert low < 2.0 < high


def _direct_estimate(value: float, error: float, p_value: float = 1e-3, trials: int = TRIALS) -> DirectEstimate:
    return DirectEstimate({"torque_Nm": value}, {"torque_Nm": error}, p_value, trials)


def test_an_interval_reaches_to_what_the_other_route_says_and_no_further_the_other_way():
    """Twice as much, said directly, is no reason to take the effect for none."""
    term = Term(COULOMB, {"torque_Nm": 2.0})
    sides = distance_to_alternatives(term, {"torque_Nm": 0.1}, _direct_estimate(3.9, 0.2), [])
    assert sides["torque_Nm"] == pytest.approx((0.0, 1.9 + 1.96 * 0.2))
    assert differs_from_none(term, wider(sides, symmetric({"torque_Nm": 0.1}))).kept
    assert not differs_from_none(
        term, distance_to_alternatives(term, {"torque_Nm": 0.1}, _direct_estimate(0.3, 0.2), [])
    ).kept
    assert distance_to_alternatives(term, {"torque_Nm": 0.1}, _direct_estimate(2.05, 0.2), [])[
        "torque_Nm"
    ] == pytest.approx((0.0, 0.05))


def test_a_direct_estimate_is_heard_by_its_error_where_losses_drown_it():
    """Noise times an effect stands beside its square in a loss; an estimate over its error sees twenty deviations."""
    term, widths = Term(COULOMB, {"torque_Nm": 2.0}), {"torque_Nm": 0.1}
    assert agree(term, widths, _direct_estimate(2.1, 0.1, p_value=0.1)).kept
    for drowned in (_direct_estimate(2.1, 1.2, p_value=0.1), _direct_estimate(2.1, 0.1, p_value=0.1, trials=1)):
        assert agree(term, widths, drowned).reason is Reason.DIRECT_NOT_SIGNIFICANT
    assert agree(term, widths, _direct_estimate(-2.1, 0.1)).reason is Reason.DIRECT_DISAGREES
    threshold = Term(replace(COULOMB, extra_starts=({"torque_Nm": 1.0},)), {"torque_Nm": 2.0})
    assert not agree(threshold, widths, _direct_estimate(2.1, 0.1, p_value=0.1)).kept


def test_test_trials_do_not_confirm_what_harms_them():
    errors = _errors(_columns(0.0), {COULOMB.key: 2.0})
    null, still = fit(errors, ()), np.ones(4)
    evidence = Evidence(null, _tried(errors, null, COULOMB), 1e-3)
    assert is_confirmed(replace(evidence, test_losses=(still, 0.9 * still))).kept
    for harm in (1.05, 1.15, 2.4):
        refusal = is_confirmed(replace(evidence, test_losses=(still, harm * still)))
        assert refusal.reason is Reason.TEST_TRIALS_WORSE


def test_what_a_single_trial_judges_has_no_sure_name():
    """A gain without an interval may be chance; the verdict recommends more trials."""

    class Told:
        def direct(self, candidate: Candidate, model: Model, trials: tuple[str, ...]) -> DirectEstimate:
            return DirectEstimate({"torque_Nm": 2.0}, {"torque_Nm": 0.05}, 1e-3, TRIALS)

    errors = _errors(_columns(0.0), {COULOMB.key: 2.0})
    null = fit(errors, ())
    found = replace(_tried(errors, null, COULOMB), direct=Told().direct(COULOMB, (), ()))
    accepted = Accepted(found, Screening((found,), (1e-6,)), 1e-6, (), MethodBias())
    selection = Selection(null, null.losses, (accepted,), None, found.fit, found.fit.losses, np.ones(1))
    alone = GAIN.model_copy(update={"ci95": (-np.inf, 1.0)})
    told = Told()
    judged = [judge(told, selection, ("t0",), [g], Comparison(0.0, (0.0, 0.0), 1.0)) for g in (GAIN, alone)]  # pyright: ignore[reportArgumentType]
    assert [j.verdict.status for j in judged] == ["effect_found", "ambiguous"]
    assert [d.reason for j in judged for _, d in j.decisions] == [Reason.NAMED, Reason.SINGLE_TRIAL]
    assert "judge by two trials or more" in judged[1].verdict.statement
