"""What trials show of effects before one is named: noticed strengths against closed forms, twins, and rivals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from simgap.problem import Term
from simgap.whole_trials.fit_model import fit_model
from simgap.whole_trials.identifiability import identifiable, twins
from simgap.whole_trials.ladder import ladder_of
from simgap.whole_trials.linearisation import inverse_of, linearise
from simgap.whole_trials.policy import POLICY
from simgap.whole_trials.score_test import scores
from tests.simgap.whole_trials.drawn_trials import ROWS, SHAPES, TRIALS, Drawn, candidates


def table(truth: dict[str, float], names: str):
    system = Drawn(truth)
    null = ladder_of(system, (), POLICY).nulls[-1]
    tried = scores(system, null, linearise(system, null.model, null.starts), candidates(names))
    return system, null, {row.name: row for row in identifiable(system, null, tried, POLICY)}


def beside(truth: dict[str, float], named: str, rivals: str) -> list[str]:
    """Names of the twins of a fitted effect."""
    system = Drawn(truth)
    (effect,) = candidates(named)
    fit = fit_model(system, (Term(effect, {"size": 1.0}),), np.zeros((TRIALS, 1)), POLICY)
    tried = scores(system, fit, linearise(system, fit.model, fit.starts), candidates(rivals))
    return [c.effect.name for c in twins(system, fit, tried, POLICY)[effect.key]]


def test_noticed_strength_is_that_of_the_closed_form():
    system, null, rows = table({}, "ramp wave")
    for name in ("ramp", "wave"):
        shape = SHAPES[name] - SHAPES[name].mean()  # The free start takes the mean.
        squares = float((np.outer(system.loads, shape) ** 2).sum())
        by_chance = stats.chi2.isf(0.5 * POLICY.alpha / 2, 1) * null.dispersion
        enough = max(by_chance, POLICY.least_gain * TRIALS * (ROWS - 1))
        weight = 2.0 / (1.0 + null.deviance / null.rows)
        assert rows[name].noticed_from["size"] == pytest.approx(np.sqrt(enough / squares / weight.mean()), rel=0.02)


def test_laws_of_one_shape_are_twins_and_others_are_not():
    _, _, rows = table({}, "ramp bow wave twin")
    assert [t.name for t in rows["bow"].twins] == ["twin"]
    assert [t.name for t in rows["twin"].twins] == ["bow"]
    assert rows["bow"].twins[0].factor > 1e3
    assert rows["ramp"].twins == rows["wave"].twins == ()


def test_the_same_shape_at_any_strength_could_take_an_effects_place():
    assert beside({"bow": 300.0}, "bow", "ramp wave twin") == ["twin"]


def test_what_is_merely_weak_has_no_twins():
    """A ramp and a wave share little: although little is there to tell them apart, neither is the other's twin."""
    assert beside({"wave": 0.03}, "wave", "ramp twin") == []


def test_an_unknown_that_changes_nothing_takes_nothing_from_the_others() -> None:
    """As the switch of a law that has two places, fitted beside others: its slopes are zero."""
    known = np.array([[4.0, 1.0], [1.0, 9.0]])
    matrix = np.zeros((3, 3))
    matrix[np.ix_([0, 2], [0, 2])] = known
    inverse = inverse_of(matrix)
    assert np.isfinite(inverse).all()
    assert inverse[np.ix_([0, 2], [0, 2])] == pytest.approx(np.linalg.inv(known), rel=1e-9)
    assert not inverse[1].any()
    assert not inverse[:, 1].any()
