"""A sensor with a lag: the closed form for tones and ramps, and its inverse."""

from __future__ import annotations

import numpy as np
import pytest

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import SensorMap, Series
from sim.effects.library import effect

HOOK = effect("sensor.lag").hook
TAU_S, RATE = 0.05, 8.0
LATE = {"time_constant_s": TAU_S}


def stamps(uneven: bool) -> np.ndarray:
    t_s = np.arange(0.0, 3.0, 2e-3)
    return t_s + uneven * 4e-4 * np.sin(900.0 * t_s)


def tone(t_s: np.ndarray, size: float, phase: float) -> dict[str, np.ndarray]:
    """A tone with its rate and acceleration."""
    q = size * np.sin(RATE * t_s - phase)[:, None]
    return {"q": q, "qd": size * RATE * np.cos(RATE * t_s - phase)[:, None], "qdd": -(RATE**2) * q}


@pytest.mark.parametrize("uneven", [False, True])
def test_a_tone_is_smaller_and_late_as_the_closed_form_says(uneven: bool):
    assert isinstance(HOOK, SensorMap)
    t_s = stamps(uneven)
    read = HOOK.report(Series(t_s, tone(t_s, 1.0, 0.0)), LATE, Place()).columns
    expected = tone(t_s, 1.0 / np.hypot(1.0, RATE * TAU_S), np.arctan(RATE * TAU_S))
    settled = t_s > 10.0 * TAU_S
    for name in ("q", "qd"):
        np.testing.assert_allclose(read[name][settled], expected[name][settled], atol=1e-3 * np.abs(read[name]).max())


def test_a_steady_motion_is_read_late_from_the_first_row():
    assert isinstance(HOOK, SensorMap)
    t_s = stamps(True)
    read = HOOK.report(Series(t_s, {"q": 3.0 * t_s[:, None]}), LATE, Place()).columns["q"][:, 0]
    np.testing.assert_allclose(read, 3.0 * (t_s - TAU_S), atol=1e-9)


def test_the_truth_is_recovered_from_readings_and_their_rates():
    assert isinstance(HOOK, SensorMap)
    t_s = stamps(False)
    read = tone(t_s, 1.0 / np.hypot(1.0, RATE * TAU_S), np.arctan(RATE * TAU_S))
    noise = 1e-3 * np.random.default_rng(0).normal(size=read["q"].shape)
    recovered = HOOK.recover(Series(t_s, {**read, "reading": read["q"] + noise}), LATE, Place()).columns
    truth = tone(t_s, 1.0, 0.0)
    inner = (t_s > TAU_S) & (t_s < t_s[-1] - TAU_S)
    for name in ("q", "qd", "qdd"):
        np.testing.assert_allclose(recovered[name][inner], truth[name][inner], atol=1e-3 * np.abs(truth[name]).max())
    np.testing.assert_allclose(recovered["reading"], recovered["q"] + noise, atol=1e-9)


def test_the_noise_of_readings_is_hardly_larger_for_a_long_time_constant():
    """Else recovered accelerations would be as large as their noise, and errors beside them would look small."""
    assert isinstance(HOOK, SensorMap)
    t_s = stamps(False)
    noise = np.random.default_rng(0).normal(size=(len(t_s), 1))
    for tau_s in (0.03, 0.1, 0.2):
        recovered = HOOK.recover(Series(t_s, {"qdd": noise}), {"time_constant_s": tau_s}, Place()).columns["qdd"]
        assert recovered.std() < 4.0


def test_without_a_lag_nothing_changes():
    assert isinstance(HOOK, SensorMap)
    t_s = stamps(True)
    series = Series(t_s, tone(t_s, 1.0, 0.3))
    for change in (HOOK.report, HOOK.recover):
        same = change(series, {"time_constant_s": 0.0}, Place())
        np.testing.assert_array_equal(same.columns["q"], series.columns["q"])


def test_readings_in_windows_go_on_from_the_first_ones():
    """Two windows of one long record, cut at rows where its readings are known."""
    assert isinstance(HOOK, SensorMap)
    assert HOOK.follow is not None
    t_s = stamps(True)
    truth = tone(t_s, 1.0, 0.3)["q"]
    read = HOOK.report(Series(t_s, {"q": truth}), LATE, Place()).columns["q"]
    rows = np.array([100, 700])[:, None] + np.arange(300)
    followed = HOOK.follow(t_s[rows], truth[rows], read[rows[:, 0]], LATE)
    np.testing.assert_allclose(followed, read[rows], atol=1e-12)
