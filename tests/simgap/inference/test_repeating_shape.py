"""What repeats of a leftover along a state: found where it does, at its size, and not where only noise is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.repeating_shape import shape_of, structures
from simgap.problem import Leftover, StateAxis

ALPHA, SHARE, KEY = 0.05, 0.9, "law@axis"
Force = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def leftover(force: Force, own: float = 3.0, seed: int = 0, trials: int = 12, stretches: int = 20) -> Leftover:
    """Noise of one, and a force of position, velocity and number of the trial (b,); the law explains `own` (rms)."""
    rng = np.random.default_rng(seed)
    position, velocity = rng.uniform(-1.0, 1.0, (2, trials * stretches))
    number = np.repeat(np.arange(trials), stretches)
    values = force(position, velocity, number.astype(np.float64)) + rng.normal(size=len(number))
    axes = [StateAxis("position", position[:, None]), StateAxis("velocity", velocity[:, None])]
    axes += [StateAxis("order of trials", number[:, None].astype(float), by_direction=True)]
    rest = {KEY: np.full((len(number), 1), own)}
    return Leftover(values[:, None], rest, np.ones(1), tuple(axes), velocity[:, None] > 0.0, number)


def nothing(position: FloatArray, velocity: FloatArray, number: FloatArray) -> FloatArray:
    return np.zeros_like(position)


def well(position: FloatArray, velocity: FloatArray, number: FloatArray) -> FloatArray:
    return np.where(np.abs(position) < 0.5, 1.5, -1.5)


def heating(position: FloatArray, velocity: FloatArray, number: FloatArray) -> FloatArray:
    return np.sign(velocity) * (number - number.mean()) / 3.0


def of_one_trial(position: FloatArray, velocity: FloatArray, number: FloatArray) -> FloatArray:
    return np.where(number == 3, 20.0 * position, 0.0)


def test_a_force_is_found_along_its_state_at_its_size() -> None:
    found = structures([leftover(well)], ALPHA)
    assert found[0].words == "position"
    assert found[0].p_value < ALPHA
    assert found[0].size == pytest.approx(1.5, rel=0.1)
    assert all(s.p_value > ALPHA for s in found[1:])


def test_friction_that_rises_from_trial_to_trial_is_found_along_their_order() -> None:
    found = structures([leftover(heating)], ALPHA)
    assert (found[0].words, found[0].p_value < ALPHA) == ("order of trials and direction", True)


def test_what_a_single_trial_shows_does_not_repeat() -> None:
    """With products within trials the size along position would be 1, a twelfth of what the trial shows."""
    found = structures([leftover(of_one_trial)], ALPHA)
    assert all(s.p_value > ALPHA for s in found)
    assert max(s.size for s in found) < 0.6


@pytest.mark.parametrize("trials", [5, 12])
def test_noise_is_rarely_a_structure(trials: int) -> None:
    false = [structures([leftover(nothing, seed=s, trials=trials)], ALPHA)[0].p_value < ALPHA for s in range(60)]
    assert np.mean(false) <= 0.1


def test_a_law_beside_which_another_force_repeats_is_refused_and_a_far_larger_one_is_not() -> None:
    for own, kept in (3.0, False), (30.0, True):
        one = leftover(well, own)
        decision = shape_of(KEY, [one], structures([one], ALPHA), ALPHA, SHARE)
        assert (decision.kept, decision.reason) == (kept, Reason.PASSED if kept else Reason.SHAPE_DIFFERS)
        assert decision.criteria[-1].value == pytest.approx(own**2 / (own**2 + 1.5**2), rel=0.05)


def test_where_noise_would_hide_the_shape_a_law_is_not_doubted_and_the_reason_says_so() -> None:
    for own, reason in (0.3, Reason.SHAPE_HIDDEN), (3.0, Reason.PASSED):
        one = leftover(nothing, own)
        decision = shape_of(KEY, [one], structures([one], ALPHA), ALPHA, SHARE)
        assert (decision.kept, decision.reason) == (True, reason)


def test_without_a_balance_the_shape_is_hidden() -> None:
    assert shape_of(KEY, [], (), ALPHA, SHARE).reason is Reason.SHAPE_HIDDEN
