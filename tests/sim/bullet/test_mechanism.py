"""Our fast roll-outs are what the engine does: both converge to the same motion as steps shrink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.sim_gap.extension import Place
from sim.bullet import mechanism
from sim.dynamics.hooks import ModelChange
from sim.dynamics.mechanism import Drive, Law, MechanismModel, Windows, rollout
from sim.dynamics.tree import Link
from sim.effects.library import effect
from simgap.sanity.convention_checks import joint_engine_checks

TIMES = np.linspace(0.0, 0.4, 21)[None]


def link(name: str, parent: int = -1, prismatic: bool = False, tilt: float = 0.0, **other) -> Link:
    X_PJ = np.eye(4)
    X_PJ[:3, :3] = Rotation.from_euler("zyx", [0.3, tilt, 0.2]).as_matrix()
    X_PJ[:3, 3] = [0.02, 0.05, -0.2] if parent >= 0 else [0.0, 0.0, 0.0]
    inertia = np.array([[2e-3, 1e-4, 0.0], [1e-4, 3e-3, 2e-4], [0.0, 2e-4, 2e-3]])
    axis = np.array([1.0, 0.0, 0.0]) if prismatic else np.array([0.0, 1.0, 0.0])
    return Link(name, parent, prismatic, axis, X_PJ, 0.4, np.array([0.01, 0.02, -0.15]), inertia, **other)


def model(*links: Link) -> MechanismModel:
    n = len(links)
    return MechanismModel(links, np.array([0.0, 0.0, -9.81]), friction=np.zeros(n), damping=np.zeros(n))


HINGE = model(link("hinge"))
CHAIN = model(link("shoulder"), link("elbow", 0, tilt=0.7), link("slide", 1, prismatic=True, tilt=0.5))
CASES = {
    "hinge": (HINGE, ()),
    "chain": (CHAIN, ()),
    "two joints side by side": (model(link("a"), link("b", prismatic=True, tilt=0.4)), ()),
    "damped": (replace(HINGE, damping=np.array([0.02])), ()),
    "dry friction, comes to rest": (replace(HINGE, friction=np.array([0.15])), ()),
    "chain with dry friction": (replace(CHAIN, friction=np.array([0.1, 0.05, 0.5])), ()),
    "armature": (model(link("hinge", armature=0.01)), ()),
    "armature of a slide on an incline": (model(link("slide", prismatic=True, tilt=0.4, armature=0.3)), ()),
    "load in doubt": (model(link("hinge", gravity_factor=0.6)), ()),
    "spring": (HINGE, ("joint.spring", {"stiffness_Nm_per_rad": 0.8, "rest_rad": 0.4})),
    "stribeck": (HINGE, ("joint.stribeck_friction", {"torque_Nm": 0.1, "velocity_radps": 1.0})),
    "drag": (HINGE, ("joint.quadratic_drag", {"drag_Nms2_per_rad2": 0.01})),
}


def gap(case: MechanismModel, laws: tuple[Law, ...], windows: Windows, step_s: float) -> tuple[float, float]:
    """Largest difference of positions between the engine and a fine roll-out of ours; travel in one step at most."""
    ours, rates = rollout(case, windows, laws, largest_step_s=1e-3 if len(case.tree) > 1 else 2e-4)
    theirs, _ = mechanism.rollout(case, windows, laws, largest_step_s=step_s)
    return float(np.abs(ours - theirs).max()), float(np.abs(rates).max()) * step_s


@pytest.mark.parametrize("name", CASES)
def test_the_engine_converges_to_our_motion(name: str):
    case, given = CASES[name]
    laws = (Law(effect(given[0]).hook, given[1], 0),) if given else ()
    n = len(case.tree)
    start = np.array([[0.6, -0.4, 0.05]])[:, :n]
    windows = Windows(TIMES, start, 0.5 * start)
    # The engine's steps are of first order: it may be ahead or behind by the travel of one step, which shrinks with it.
    for step_s in (4e-3, 1e-3) if n > 1 else (4e-3, 1e-3, 2.5e-4):
        apart, travel = gap(case, laws, windows, step_s)
        assert apart < travel


DRIVEN = replace(HINGE, drive=Drive("position_pd", kp=np.array([3.0]), kd=np.array([0.1]), effort_limit=0.5))
CHANGES = {
    "as declared": (),
    "other gains": ("robot.pd_gains", {"kp": 1.5, "kd": 0.3}),
    "friction below zero": ("joint.viscous_friction", {"damping_Nms_per_rad": -0.05}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_driven_joints_follow_the_same_command(name: str):
    command = 0.3 * np.sin(4.0 * TIMES[0])[None, :, None]
    windows = Windows(TIMES, np.array([[0.2]]), np.zeros((1, 1)), command=command)
    driven, given = DRIVEN, CHANGES[name]
    if given:
        hook = effect(given[0]).hook
        assert isinstance(hook, ModelChange)
        driven = hook.change(DRIVEN, given[1], Place(joint="hinge"))
        assert np.abs(rollout(driven, windows)[0] - rollout(DRIVEN, windows)[0]).max() > 0.01
    apart, travel = gap(driven, (), windows, 1e-3)
    assert apart < travel


def test_a_declared_effort_and_a_gain_act_in_both():
    effort = 0.4 * np.sign(np.sin(5.0 * TIMES[0]))[None, :, None]
    case = replace(HINGE, drive=Drive("effort", kp=np.zeros(1), kd=np.zeros(1)))
    windows = Windows(TIMES, np.zeros((1, 1)), np.zeros((1, 1)), effort=effort)
    gain = Law(effect("actuator.gain").hook, {"gain": 0.7}, 0)
    apart, travel = gap(case, (gain,), windows, 1e-3)
    assert apart < travel
    assert travel < 0.1 * np.abs(rollout(case, windows)[0] - rollout(case, windows, (gain,))[0]).max()


def test_worlds_are_independent():
    windows = Windows(np.repeat(TIMES, 2, axis=0), np.array([[0.6], [-0.2]]), np.zeros((2, 1)))
    both, _ = mechanism.rollout(HINGE, windows)
    alone, _ = mechanism.rollout(HINGE, Windows(TIMES, np.array([[-0.2]]), np.zeros((1, 1))))
    np.testing.assert_array_equal(both[1], alone[0])


def test_an_armature_inside_a_chain_is_refused():
    chain = model(link("shoulder", armature=0.01), link("elbow", 0))
    with pytest.raises(ValueError, match="armature"):
        mechanism.rollout(chain, Windows(TIMES, np.zeros((1, 2)), np.zeros((1, 2))))


@pytest.mark.parametrize("case", [HINGE, CHAIN], ids=["hinge", "chain"])
def test_both_engines_pass_the_trap_experiments(case: MechanismModel):
    for engine in (rollout, mechanism.rollout):
        assert {t.name: t.status for t in joint_engine_checks(engine, case)} == {
            "joint_motor_and_damping_off": "ok",
            "joint_inertia_held": "ok",
        }


def test_a_joint_motor_left_on_is_seen():
    def braked(case: MechanismModel, windows: Windows, laws=()):
        return rollout(replace(case, friction=np.full(len(case.tree), 1.0)), windows, laws)

    assert joint_engine_checks(braked, HINGE)[0].status == "suspect"
