"""The whole-trial check: a right model comes down to the noise, a wrong one does not, and starts may be anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from simgap.problem import Term
from simgap.whole_trials.check import check_whole_trials, confirmed
from simgap.whole_trials.confidence_set import confidence_set
from simgap.whole_trials.fit_model import fit_model, half_widths
from simgap.whole_trials.held_out import held_out_losses
from simgap.whole_trials.losses import losses
from simgap.whole_trials.policy import POLICY
from simgap.whole_trials.search_models import ModelSearch
from tests.simgap.whole_trials.drawn_trials import SHAPES, TRIALS, Drawn, T, candidates, keys, searched


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_needs_no_effect(seed: int) -> None:
    search = searched(Drawn({}, seed=seed), "ramp bow wave")
    assert search.size == 0
    assert explained(search, Drawn({}, seed=seed + 100))


@pytest.mark.parametrize("seed", range(5))
def test_two_causes_are_certain_and_their_intervals_hold_them(seed: int) -> None:
    truth = {"ramp": 6.0, "wave": 3.0}
    search = searched(Drawn(truth, seed=seed), "ramp bow wave")
    assert confidence_set(search, POLICY).certain == keys("ramp wave")
    widths = half_widths(search.chosen.fit, 3.0)
    for term in search.chosen.fit.effects:
        assert abs(term.values["size"] - truth[term.candidate.effect.name]) < widths[term.candidate.key]["size"]


@pytest.mark.parametrize("seed", range(5))
def test_twins_are_a_group_and_neither_is_certain(seed: int) -> None:
    search = searched(Drawn({"bow": 20.0}, seed=seed), "ramp bow twin")
    found = confidence_set(search, POLICY)
    assert found.certain == frozenset()
    assert {m.fit.keys for m in found.models} == {frozenset(keys("bow")), frozenset(keys("twin"))}


def test_a_cause_outside_the_library_stays_above_the_noise() -> None:
    search = searched(Drawn({}, outside=6.0), "ramp bow")
    assert search.chosen.fit.excess > 1.0
    assert not explained(search, Drawn({}, outside=6.0, seed=1))


def test_a_right_model_explains_other_trials_and_a_model_without_it_does_not() -> None:
    truth = {"ramp": 6.0}
    right, without = (searched(Drawn(truth), names) for names in ("ramp bow", "wave"))
    assert explained(right, Drawn(truth, seed=1))
    assert not explained(without, Drawn(truth, seed=1))


def test_what_acts_in_training_trials_only_is_not_explained_by_quiet_test_trials() -> None:
    search = searched(Drawn({}, outside=6.0), "ramp bow")
    assert not explained(search, Drawn({}, seed=1))


def explained(search: ModelSearch, test: Drawn) -> bool:
    null, chosen = search.null.fit, search.chosen.fit
    return check_whole_trials(test, null.model, chosen.model, (null, chosen), POLICY).explains.kept


def test_held_out_losses_follow_those_of_leaving_a_trial_out() -> None:
    """To first order: with one parameter among 12 trials, within a tenth of what leaving out adds."""
    system = Drawn({"ramp": 5.0})
    model = (Term(candidates("ramp")[0], {"size": 0.0}),)
    whole = fit_model(system, model, np.zeros((TRIALS, 1)), POLICY)
    shape = system.loads[:, None] * SHAPES["ramp"][None]
    shape = shape - shape.mean(axis=1, keepdims=True)
    added, expected = held_out_losses(whole) - whole.losses, []
    for left_out in range(TRIALS):
        rest = np.delete(np.arange(TRIALS), left_out)
        size = (shape[rest] * system.readings[rest]).sum() / (shape[rest] ** 2).sum()
        error = system.readings[left_out] - size * shape[left_out]
        deviance = ((error - error.mean()) ** 2).sum()
        expected.append(losses(np.array([deviance]), whole.rows[:1])[0] - whole.losses[left_out])
    assert added.sum() == pytest.approx(2.0 * np.sum(expected) / 2.0, rel=0.3)
    assert np.corrcoef(added, expected)[0, 1] > 0.95


def test_a_violent_trial_does_not_outvote_the_others() -> None:
    system = Drawn({"ramp": 6.0})
    system.readings[3] += 400.0 * T**2
    search = searched(system, "ramp bow")
    assert "ramp@world" in search.growths[0].models[0].fit.keys
    size = search.growths[0].models[0].fit.effects[0].values["size"]
    assert size == pytest.approx(6.0, abs=1.5)


def test_test_trials_have_the_last_word() -> None:
    """What training trials show and test trials contradict is not taken."""
    search = searched(Drawn({"ramp": 6.0}), "ramp bow")
    assert confirmed(Drawn({"ramp": 6.0}, seed=1), search, POLICY).size == 1
    assert confirmed(Drawn({"ramp": -6.0}, seed=1), search, POLICY).size == 0


def test_intervals_hold_the_truth_about_as_often_as_they_say() -> None:
    held = 0
    for seed in range(60):
        fit = searched(Drawn({"ramp": 6.0}, seed=seed), "ramp").chosen.fit
        width = half_widths(fit, 1.96)[fit.effects[0].candidate.key]["size"]
        held += abs(fit.effects[0].values["size"] - 6.0) < width
    assert 0.88 * 60 <= held <= 60
