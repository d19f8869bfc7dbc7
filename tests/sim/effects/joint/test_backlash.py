"""Play is a light drive between two flanks: what a crossing costs a joint follows from momentum alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from schemas.arrays import FloatArray
from sim.dynamics.mechanism import Drive, Law, MechanismModel, Windows, rollout
from sim.dynamics.tree import Link
from sim.effects.library import effect

HOOK = effect("joint.backlash").hook
MASS_KG = 3.0
SLIDE = MechanismModel(
    (
        Link(
            name="slide",
            parent=-1,
            prismatic=True,
            axis_J=np.array([1.0, 0.0, 0.0]),
            X_PJ=np.eye(4),
            mass_kg=MASS_KG,
            com_J=np.zeros(3),
            inertia_J=np.eye(3),
            armature=0.0,
        ),
    ),
    np.zeros(3),
    np.zeros(1),
    np.zeros(1),
    Drive("effort"),
)
ROW_S = 2e-3
T_S = np.arange(0.0, 2.0, ROW_S)
EFFORT_N = 6.0 * np.cos(2.0 * np.pi * T_S)  # leans forward, from 0.25 s back, from 0.75 s forward again


def _moved(laws: tuple[Law, ...], step_s: float = ROW_S) -> FloatArray:
    windows = Windows(T_S[None], np.zeros((1, 1)), np.zeros((1, 1)), effort=EFFORT_N[None, :, None])
    return rollout(SLIDE, windows, laws, largest_step_s=step_s)[0][0, :, 0]


def _play(lag_kgm: float, gap_m: float) -> tuple[Law, ...]:
    return (Law(HOOK, {"gap_inertia_kgm2rad": lag_kgm, "gap_rad": gap_m}, 0),)


@pytest.mark.parametrize("gap_m", [0.005, 0.05])
def test_a_crossing_costs_gap_times_drive_inertia_however_wide_the_gap(gap_m: float):
    """All momentum that the effort gives is the joint's or the drive's: m (x - x_without) = -m_drive x (its travel)."""
    lag = 4e-3
    behind = MASS_KG * (_moved(_play(lag, gap_m)) - _moved(()))
    leaning_back, forward = (T_S > 0.55) & (T_S < 0.74), (T_S > 1.05) & (T_S < 1.24)
    np.testing.assert_allclose(behind[T_S < 0.24], 0.0, atol=1e-12)
    np.testing.assert_allclose(behind[leaning_back], lag, rtol=0.1)
    np.testing.assert_allclose(behind[forward], 0.0, atol=0.1 * lag)


def test_a_drive_without_inertia_crosses_at_once():
    np.testing.assert_allclose(_moved(_play(0.0, 0.05)), _moved(()), atol=2e-4)


def test_steps_change_little_wherever_in_them_the_drive_lands():
    law = _play(4e-3, 0.05)
    coarse, fine = _moved(law), _moved(law, ROW_S / 8.0)
    assert np.abs(coarse - fine).max() < 0.1 * np.abs(fine - _moved(())).max()


def test_the_law_is_two_masses_with_a_stiff_soft_landing():
    """Against both equations of motion, with flanks that give way and lose all energy of a blow."""
    drive_kg, gap_m = 0.08, 0.05
    stiff = drive_kg * 2000.0**2
    damping = 4.0 * np.sqrt(stiff * drive_kg)

    def rates(t: float, y: FloatArray) -> FloatArray:
        x, v, motor, speed = y
        apart = motor - x
        deep = np.sign(apart) * max(abs(apart) - 0.5 * gap_m, 0.0)
        pressed = stiff * deep + damping * (speed - v) * (deep != 0.0)
        pressed = pressed if pressed * deep > 0.0 else 0.0
        # The joint's declared mass is with the drive, as it moves while the drive leans on it.
        return np.array([v, pressed / (MASS_KG - drive_kg), speed, (_effort(t) - pressed) / drive_kg])

    def _effort(t: float) -> float:
        return float(EFFORT_N[min(int(t / ROW_S + 1e-9), len(EFFORT_N) - 1)])

    truth = solve_ivp(rates, (0.0, T_S[-1]), [0.0, 0.0, 0.5 * gap_m, 0.0], "LSODA", T_S, max_step=5e-4, rtol=1e-7)
    without, law = _moved(()), _moved(_play(drive_kg * gap_m, gap_m))
    lag = np.abs(truth.y[0] - without).max()
    assert np.abs(truth.y[0] - law).max() < 0.15 * lag
