"""The miss of a restarted model against its closed form, and the search for a strength."""

from __future__ import annotations

import numpy as np
import pytest

from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant, Trial, believed_numbers, observe
from tests.suites.gap2.generate.power import miss, strength_for

SIGMA, FORCE_N, MASS_KG, ROWS = 1e-3, 0.1, 2.0, 101
T = np.linspace(0.0, 1.0, ROWS)


def slide() -> tuple[Plant, Trial]:
    mass, none = np.array([MASS_KG]), np.zeros(1)
    plant = Plant("a test", "effort", True, False, mass, mass, none, none, believed_numbers(1))
    return plant, Trial(T, np.zeros((ROWS, 1)), np.ones(ROWS), np.array([0.0, 0.3]), 0.0, 0.0)


@pytest.mark.parametrize(("horizon_s", "rows"), [(0.1, 10), (0.25, 25), (float("inf"), 100)])
def test_unknown_push_misses_by_half_a_t_squared_from_each_restart(horizon_s: float, rows: int) -> None:
    plant, trial = slide()
    readings = observe(plant, Hidden(numbers={Number.BIAS: FORCE_N}), [trial], 1e-3)
    since = T[1 : rows + 1]
    errors = 0.5 * FORCE_N / MASS_KG * since**2
    expected = np.sqrt(np.mean(errors**2)) / (np.sqrt(2.0) * SIGMA)
    assert miss(plant, readings, [trial], SIGMA, horizon_s, 1e-3) == pytest.approx(expected, rel=1e-6)


def test_strength_is_found_where_the_miss_is_proportional_and_where_it_has_a_threshold() -> None:
    strength, reached = strength_for(lambda s: 40.0 * s, 1.33, 1e-5, 1.0)
    assert reached
    assert 40.0 * strength == pytest.approx(1.33, rel=0.05)
    strength, reached = strength_for(lambda s: 30.0 * max(s - 0.6, 0.0), 1.33, 1e-5, 1.0)
    assert reached
    assert 30.0 * (strength - 0.6) == pytest.approx(1.33, rel=0.05)


def test_weak_cause_gives_its_most_and_says_that_the_level_is_not_reached() -> None:
    assert strength_for(lambda s: 0.5 * s, 1.33, 1e-5, 0.8) == (0.8, False)
