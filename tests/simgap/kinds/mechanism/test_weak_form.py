"""Means of accelerations by parts: exact for parabolas, at uneven stamps, and without the bias of local cubics."""

from __future__ import annotations

import numpy as np
import pytest

from simgap.kinds.mechanism.smooth import smooth
from simgap.kinds.mechanism.weak_form import mean_accelerations, means, weak_means

STEP_S, ROWS, STRETCH = 5e-3, 400, 48
T_S = STEP_S * np.arange(ROWS, dtype=np.float64)


def test_a_parabola_has_its_acceleration_in_every_stretch() -> None:
    weak = [weak_means(T_S, STRETCH, 13)]
    q = (2.0 - 3.0 * T_S + 0.5 * 7.0 * T_S**2)[:, None]
    assert mean_accelerations(weak, q) == pytest.approx(7.0, rel=1e-9)
    assert means(weak, np.full((ROWS, 1), 7.0)) == pytest.approx(7.0, rel=1e-9)


@pytest.mark.parametrize(("count", "stretches"), [(12, 0), (13, 0), (14, 0), (15, 1), (20, 1)])
def test_short_trials_have_the_acceleration_of_a_parabola_or_no_stretch(count: int, stretches: int) -> None:
    weak = [weak_means(T_S[:count], STRETCH, 13)]
    found = mean_accelerations(weak, 3.5 * T_S[:count, None] ** 2)
    assert found == pytest.approx(np.full((stretches, 1), 7.0), rel=1e-9)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_a_fast_swing_balances_where_local_cubics_lose_a_tenth(jitter: float) -> None:
    rng = np.random.default_rng(0)
    t_s = T_S + jitter * STEP_S * rng.uniform(-0.5, 0.5, ROWS)
    rate = 2.0 * np.pi * 6.0
    q = np.sin(rate * t_s)[:, None]
    smoothed = smooth(t_s, q, 0.06)
    weak = [weak_means(t_s, STRETCH, smoothed.rows)]
    inner = slice(1, -1)
    expected = means(weak, -(rate**2) * q)[inner]
    size = np.abs(expected).max()
    assert np.abs(mean_accelerations(weak, smoothed.q)[inner] - expected).max() < 0.01 * size
    assert np.abs(means(weak, smoothed.qdd)[inner] - expected).max() > 0.1 * size


def test_trials_below_one_another_do_not_mix() -> None:
    weak = [weak_means(T_S[:200], STRETCH, 13), weak_means(T_S[:150], STRETCH, 13)]
    values = np.concatenate([np.zeros((200, 1)), np.ones((150, 1))])
    found = means(weak, values)[:, 0]
    assert sorted(set(found.round(9))) == [0.0, 1.0]
    assert np.count_nonzero(found > 0.5) == weak[1].stretches
