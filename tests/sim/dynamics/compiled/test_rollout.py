"""Compiled roll-outs are those of the NumPy form: every form of the dynamics, every drive, every law of a step."""

from __future__ import annotations

import numpy as np
import pytest

from schemas.arrays import FloatArray
from sim.dynamics.hooks import StepHook
from sim.dynamics.mechanism import SUPPLY, Drive, Law, MechanismModel, Windows, rollout, rollout_in_numpy
from sim.dynamics.tree import Link, Tree
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS

WORLDS, ROWS, STEP_S = 3, 40, 2e-3
STEP_EFFECTS = [e for e in EFFECTS if isinstance(e.hook, StepHook)]
IN_LOOP_EFFECTS = [e for e in EFFECTS if e.in_loop is not None]
VALUES = {
    "joint.spring": {"stiffness_Nm_per_rad": 1.0, "rest_rad": 0.1},
    "joint.hard_stop": {"lower_rad": -0.3, "upper_rad": 0.3, "stiffness_Nm_per_rad": 30.0, "loss_s_per_rad": 0.5},
    "joint.backlash": {"gap_inertia_kgm2rad": 1e-4, "gap_rad": 0.02},
    "actuator.saturation": {"limit_Nm": 0.02},
    "actuator.supply_sag": {"sag": 1.0, "nominal_V": 12.0},
}


def at(x_m: float, z_m: float) -> FloatArray:
    X_PJ = np.eye(4)
    X_PJ[:3, 3] = (x_m, 0.0, z_m)
    return X_PJ


def link(name: str, parent: int, prismatic: bool, axis: tuple[float, float, float], X_PJ: FloatArray) -> Link:
    return Link(
        name, parent, prismatic, np.array(axis), X_PJ, 0.7, np.array([0.05, 0.01, -0.2]),
        np.diag([0.01, 0.012, 0.008]), armature=0.002, gravity_factor=1.1,
    )  # fmt: skip


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TREES: dict[str, Tree] = {
    "hinge and slide": (link("a", -1, False, Y, np.eye(4)), link("b", -1, True, X, np.eye(4))),
    "planar chain": (link("a", -1, False, Y, np.eye(4)), link("b", 0, False, Y, at(0.1, -0.3))),
    "tree": (
        link("a", -1, False, Z, np.eye(4)),
        link("b", 0, False, Y, at(0.1, -0.3)),
        link("c", 1, True, X, at(0.1, -0.1)),
    ),
}


def both(tree: Tree, drive: str, laws: list[Law]) -> tuple[FloatArray, FloatArray]:
    """Positions and rates (2, w, k, j) of the compiled and of the NumPy form."""
    joints, rng = len(tree), np.random.default_rng(3)
    drives = {
        "none": Drive("none"),
        "effort": Drive("effort", effort_limit=2.0, effort_per_unit=1.1),
        "position_pd": Drive("position_pd", np.full(joints, 5.0), np.full(joints, 0.3), 2.0, 1.1),
    }
    model = MechanismModel(
        tree, np.array([0.3, 0.1, -9.81]), np.full(joints, 0.05), np.full(joints, 0.02), drives[drive]
    )
    t_s = np.cumsum(0.005 * (1.0 + 0.1 * rng.random((WORLDS, ROWS))), axis=1)
    inputs = np.cumsum(rng.normal(scale=0.05, size=(WORLDS, ROWS, joints)), axis=1)
    volts = {SUPPLY: 11.0 + rng.random((WORLDS, ROWS))}
    windows = Windows(t_s, rng.normal(size=(WORLDS, joints)), rng.normal(size=(WORLDS, joints)), inputs, inputs, volts)
    typical_s = np.median(np.diff(t_s, axis=1), axis=0)
    steps = np.maximum(1, np.ceil(typical_s / STEP_S - 0.1)).astype(int)
    plain = rollout_in_numpy(model, windows, laws, steps, typical_s)
    return np.stack(rollout(model, windows, laws, largest_step_s=STEP_S)), np.stack(plain)


def law_of(effect: Effect, joint: int) -> Law:
    assert isinstance(effect.hook, StepHook)
    given = {p.name: 0.05 if p.null == 0.0 else min(p.null, 0.5) for p in effect.parameters}
    return Law(effect.hook, VALUES.get(effect.name, given), joint)


@pytest.mark.parametrize("drive", ["none", "effort", "position_pd"])
@pytest.mark.parametrize("tree", TREES)
def test_every_form_of_the_dynamics_and_drive_agrees(tree: str, drive: str) -> None:
    compiled, plain = both(TREES[tree], drive, [])
    assert np.ptp(plain[0]) > 0.1
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("effect", STEP_EFFECTS, ids=lambda e: e.name)
@pytest.mark.parametrize("drive", ["effort", "position_pd"])
def test_every_law_of_a_step_agrees(effect: Effect, drive: str) -> None:
    tree = TREES["hinge and slide"]
    compiled, plain = both(tree, drive, [law_of(effect, 0)])
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-9)
    without, _ = both(tree, drive, [])
    assert np.abs(compiled - without).max() > 1e-7  # the law did act


@pytest.mark.parametrize("effect", IN_LOOP_EFFECTS, ids=lambda e: e.name)
def test_laws_inside_a_loop_agree(effect: Effect) -> None:
    assert effect.in_loop is not None
    law = Law(effect.in_loop, {effect.parameters[0].name: 0.0045}, 0)
    compiled, plain = both(TREES["hinge and slide"], "position_pd", [law])
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-9)
    without, _ = both(TREES["hinge and slide"], "position_pd", [])
    assert np.abs(compiled - without).max() > 1e-5


def test_laws_with_load_and_memory_agree_beside_one_another_in_a_chain() -> None:
    named = {e.name: e for e in STEP_EFFECTS}
    laws = [law_of(named[n], 1) for n in ("joint.backlash", "joint.load_dependent_friction", "joint.spring")]
    compiled, plain = both(TREES["planar chain"], "effort", laws)
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-9)


def test_any_number_of_laws_act() -> None:
    spring = next(e for e in STEP_EFFECTS if e.name == "joint.spring")
    laws = [law_of(spring, 0)] * 12
    compiled, plain = both(TREES["hinge and slide"], "none", laws)
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-9)
    fewer, _ = both(TREES["hinge and slide"], "none", laws[1:])
    assert np.abs(compiled - fewer).max() > 1e-6
