"""Viscous friction below zero: beside a drive it is a candidate, a joint alone only loses energy."""

from __future__ import annotations

import numpy as np
import pytest

from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import Drive, MechanismModel, Windows, rollout
from sim.dynamics.tree import Link
from simgap.kinds.mechanism.candidates import candidates_of

MASS_KG = 2.0
LINK = Link("slide", -1, True, np.array([1.0, 0.0, 0.0]), np.eye(4), MASS_KG, np.zeros(3), np.eye(3))
T_S = np.arange(0.0, 1.0, 2e-3)
STEP_S = 4e-3


def slide(drive: Drive, damping: float = 0.0) -> MechanismModel:
    return MechanismModel((LINK,), np.zeros(3), np.zeros(1), np.array([damping]), drive)


@pytest.mark.parametrize(("type", "negative"), [("none", False), ("effort", True), ("position_pd", True)])
def test_only_a_drive_can_give_what_friction_below_zero_takes(type, negative: bool):
    q = np.sin(3.0 * T_S)[:, None]
    series = Series(T_S, {"q": q, "qd": 3.0 * np.cos(3.0 * T_S)[:, None], "qdd": -9.0 * q, "command": q, "effort": q})
    friction = next(
        c
        for c in candidates_of(slide(Drive(type, np.array([80.0]), np.array([5.0]))), [series], STEP_S)
        if c.effect.name == "joint.viscous_friction"
    )
    low, high = friction.bounds["damping_Nms_per_rad"]
    assert (low < 0.0) is negative
    assert low <= friction.null["damping_Nms_per_rad"] == 0.0 < high
    assert -low <= 0.3 * MASS_KG / STEP_S


@pytest.mark.parametrize("damping", [-0.8, 0.8])
def test_a_slide_without_force_gains_or_loses_speed_by_the_closed_form(damping: float):
    windows = Windows(T_S[None], np.zeros((1, 1)), np.ones((1, 1)), effort=np.zeros((1, len(T_S), 1)))
    qd = rollout(slide(Drive("effort"), damping), windows, largest_step_s=1e-3)[1][0, :, 0]
    np.testing.assert_allclose(qd, np.exp(-damping / MASS_KG * T_S), rtol=1e-3)
