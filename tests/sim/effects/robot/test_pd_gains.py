"""Other gains of a position drive: the closed form of the linear loop, and which logs make them a candidate."""

from __future__ import annotations

import numpy as np
import pytest

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Series
from sim.dynamics.mechanism import Drive, MechanismModel, Windows, rollout
from sim.dynamics.tree import Link
from sim.effects.library import effect
from simgap.kinds.mechanism.candidates import candidates_of

NAME = "robot.pd_gains"
MASS_KG, KP, KD = 2.0, 80.0, 5.0
LINK = Link("slide", -1, True, np.array([1.0, 0.0, 0.0]), np.eye(4), MASS_KG, np.zeros(3), np.eye(3))
T_S = np.arange(0.0, 1.0, 2e-3)


def slide(drive: Drive) -> MechanismModel:
    return MechanismModel((LINK,), np.zeros(3), np.zeros(1), np.zeros(1), drive)


def changed(model: MechanismModel, kp: float, kd: float) -> MechanismModel:
    hook = effect(NAME).hook
    assert isinstance(hook, ModelChange)
    return hook.change(model, {"kp": kp, "kd": kd}, Place(joint="slide"))


@pytest.mark.parametrize(("kp", "kd", "per_unit"), [(50.0, 4.0, 1.0), (120.0, 12.0, 1.0), (50.0, 4.0, 0.5)])
def test_a_step_is_followed_with_the_frequency_and_decay_of_the_gains(kp: float, kd: float, per_unit: float):
    drive = Drive("position_pd", np.array([KP]), np.array([KD]), effort_per_unit=per_unit)
    model = changed(slide(drive), kp, kd)
    windows = Windows(T_S[None], np.zeros((1, 1)), np.zeros((1, 1)), command=np.ones((1, len(T_S), 1)))
    q = rollout(model, windows, largest_step_s=1e-3)[0][0, :, 0]
    decay = 0.5 * kd * per_unit / MASS_KG
    swing = np.sqrt(kp * per_unit / MASS_KG - decay**2)
    expected = 1.0 - np.exp(-decay * T_S) * (np.cos(swing * T_S) + decay / swing * np.sin(swing * T_S))
    np.testing.assert_allclose(q, expected, atol=2e-3)


def test_gains_at_their_null_are_the_declared_drive():
    model = slide(Drive("position_pd", np.array([KP]), np.array([KD])))
    again = changed(model, KP, KD)
    assert (again.drive.kp.tolist(), again.drive.kd.tolist()) == ([KP], [KD])


@pytest.mark.parametrize(("type", "observable"), [("position_pd", True), ("effort", False), ("none", False)])
def test_only_a_position_drive_shows_gains(type, observable: bool):
    q = np.sin(T_S)[:, None]
    series = Series(T_S, {"q": q, "qd": np.cos(T_S)[:, None], "qdd": -q, "command": 1.1 * q, "effort": q})
    model = slide(Drive(type, np.array([KP]), np.array([KD])))
    gains = [c for c in candidates_of(model, [series], 4e-3) if c.effect.name == NAME]
    assert len(gains) == observable
    assert [c.null for c in gains] == [{"kp": KP, "kd": KD}] * observable
