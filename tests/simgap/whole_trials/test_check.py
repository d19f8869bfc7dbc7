"""The whole-trial check: a right model comes down to the noise, a wrong one does not, and starts may be anywhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from schemas.arrays import FloatArray
from simgap.problem import Candidate, Model, Term
from simgap.whole_trials.check import check_whole_trials
from simgap.whole_trials.confidence_set import confidence_set
from simgap.whole_trials.fit_model import fit_model, half_widths, losses
from simgap.whole_trials.held_out import held_out_losses
from simgap.whole_trials.ladder import ladder_of
from simgap.whole_trials.policy import POLICY
from simgap.whole_trials.search_models import ModelSearch, search_models

TRIALS, ROWS = 12, 80
T = np.linspace(0.0, 1.0, ROWS)
SHAPES = {"ramp": T, "bow": T * (1.0 - T), "wave": np.sin(9.0 * T), "twin": 2.0 * T * (1.0 - T)}


class Drawn:
    """Lines of trials: a free start each, the sum of shapes times the trial's load, noise of one."""

    def __init__(self, truth: dict[str, float], outside: float = 0.0, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.loads = 1.0 + rng.random(TRIALS)
        starts = rng.normal(scale=30.0, size=TRIALS)
        wild = outside * np.cos(23.0 * T)[None] * rng.normal(size=(TRIALS, 1))
        self.readings = self._lines(truth, starts) + wild + rng.normal(size=(TRIALS, ROWS))

    def _lines(self, values: dict[str, float], starts: FloatArray) -> FloatArray:
        total = sum((v * SHAPES[n] for n, v in values.items()), np.zeros(ROWS))
        return self.loads[:, None] * total[None] + starts[:, None]

    @property
    def trial_ids(self) -> tuple[str, ...]:
        return tuple(map(str, range(TRIALS)))

    @property
    def start_steps(self) -> FloatArray:
        return np.ones((TRIALS, 1))

    @property
    def channel_count(self) -> int:
        return 1

    @property
    def piece_starts(self) -> tuple[tuple[int, int], ...]:
        return tuple((trial, 0) for trial in range(TRIALS))

    def pieces(self, count: int) -> None:
        return None

    def finer(self) -> Drawn:
        return self

    def with_noise_from(self, model: Model, starts: FloatArray) -> Drawn:
        return self

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        values: dict[str, float] = {}
        for term in model:
            name = term.candidate.effect
            values[str(name)] = values.get(str(name), 0.0) + term.values["size"]
        return np.stack([self._lines(values, s[:, 0]) - self.readings for s in starts])


class Named:
    """Stands for an effect of a candidate: only its name is read."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __str__(self) -> str:
        return self.name


def candidates(names: Sequence[str]) -> list[Candidate]:
    from schemas.gap import Place

    none = {"size": 0.0}
    return [
        Candidate(Named(n), Place(), none, none, {"size": (-500.0, 500.0)})  # pyright: ignore[reportArgumentType]
        for n in names
    ]


def searched(system: Drawn, names: str) -> ModelSearch:
    return search_models(ladder_of(system, (), POLICY), candidates(names.split()), POLICY)


def keys(names: str) -> set[str]:
    return {f"{n}@world" for n in names.split()}


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
        assert abs(term.values["size"] - truth[str(term.candidate.effect)]) < widths[term.candidate.key]["size"]


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
    model = (Term(candidates(["ramp"])[0], {"size": 0.0}),)
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
