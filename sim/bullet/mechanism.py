"""Mechanism roll-outs in PyBullet, to check those of `sim.dynamics.mechanism`: same multibody, same effects.

Joint motors are off unless they model dry friction (a velocity motor with target 0 and limited effort is exactly
that), damping is zero, effects act as efforts in each step. Slow: one world at a time.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pybullet

from formats import write_urdf
from geom.mass.principal_axes import principal_axes
from geom.pose import matrix_of, pose
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedJoint, DescribedLink, Inertial, JointLimits, RobotDescription
from sim.dynamics.hooks import EffortMap, JointFriction, JointState, JointTorque
from sim.dynamics.joint_dynamics import joint_dynamics
from sim.dynamics.mechanism import Law, MechanismModel, Windows, commanded_effort
from sim.dynamics.tree import Link, Tree

MECHANISM_STEP_S = 1e-3
_BOUNDLESS = 1e9  # N, N m, m/s, rad/s: more than any joint of a recording has


def rollout(
    model: MechanismModel, windows: Windows, laws: Sequence[Law] = (), *, largest_step_s: float = MECHANISM_STEP_S
) -> tuple[FloatArray, FloatArray]:
    """Joint positions and rates (w, k, j) at the stamps of `windows`, as `sim.dynamics.mechanism.rollout`.

    Raises ValueError for an armature inside a chain, which no rigid link can represent.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = _load(model, client)
        worlds, stamps = windows.t_s.shape
        out = np.empty((2, worlds, stamps, len(model.tree)))
        for w in range(worlds):
            out[:, w] = _one_world(model, _only(windows, w), laws, body, client, largest_step_s)
        return out[0], out[1]
    finally:
        pybullet.disconnect(physicsClientId=client)


def _only(windows: Windows, w: int) -> Windows:
    """One world of all windows."""
    column = np.s_[w : w + 1]
    return Windows(
        windows.t_s[column],
        windows.q0[column],
        windows.qd0[column],
        None if windows.command is None else windows.command[column],
        None if windows.effort is None else windows.effort[column],
        {name: values[column] for name, values in windows.aux.items()},
    )


def _one_world(
    model: MechanismModel, windows: Windows, laws: Sequence[Law], body: int, client: int, largest_step_s: float
) -> FloatArray:
    """(2, k, j) positions and rates of one world."""
    joints = range(len(model.tree))
    for j in joints:
        pybullet.resetJointState(body, j, windows.q0[0, j], windows.qd0[0, j], physicsClientId=client)
    memory: list[dict[str, FloatArray]] = [{} for _ in laws]
    out = [_state(body, joints, client)]
    for k in range(windows.t_s.shape[1] - 1):
        span = float(windows.t_s[0, k + 1] - windows.t_s[0, k])
        steps = max(1, int(np.ceil(span / largest_step_s - 1e-9)))
        aux = {name: values[:, k, None] for name, values in windows.aux.items()}
        for s in range(steps if span > 0.0 else 0):
            h = span / steps
            # Before the motors: the engine turns their limits of effort into impulses when they are set.
            pybullet.setTimeStep(h, physicsClientId=client)
            q, qd = _state(body, joints, client)[:, None]
            t = windows.t_s[:, k, None] + s * h
            commanded = commanded_effort(model.drive, windows, k, q, qd)
            effort, largest = _efforts(model, laws, memory, JointState(t, q, qd, commanded, commanded, h, aux))
            _drive(body, effort[0], largest[0], client)
            pybullet.stepSimulation(physicsClientId=client)
        out.append(_state(body, joints, client))
    return np.stack(out, axis=1)


def _efforts(
    model: MechanismModel, laws: Sequence[Law], memory: Sequence[dict[str, FloatArray]], state: JointState
) -> tuple[FloatArray, FloatArray]:
    """Net effort beside gravity and inertia (1, j), and the largest dry friction (1, j)."""
    load = joint_dynamics(model.tree, model.gravity_W).at(state.q).load(state.qd)
    effort, largest = state.effort.copy(), np.broadcast_to(model.friction, state.q.shape).copy()

    def at(j: int) -> JointState:
        column = np.s_[:, j : j + 1]
        return JointState(
            state.t_s, state.q[column], state.qd[column], effort[column], load[column], state.dt_s, state.aux
        )

    for law, law_memory in zip(laws, memory, strict=True):
        if isinstance(law.hook, EffortMap):
            effort[:, law.joint, None] = law.hook.map(at(law.joint), law.params, law_memory)
    passive = -model.damping * state.qd
    for law, law_memory in zip(laws, memory, strict=True):
        if isinstance(law.hook, JointTorque):
            passive[:, law.joint, None] += law.hook.torque(at(law.joint), law.params, law_memory)
        elif isinstance(law.hook, JointFriction):
            direction = np.where(state.qd[:, law.joint, None] < 0.0, -1.0, 1.0)
            now = replace(at(law.joint), friction=largest[:, law.joint, None].copy())
            largest[:, law.joint, None] += law.hook.limit(now, law.params, direction)
    # Gravity acts on the rigid links alone; the model may have gravity factors.
    zero = np.zeros_like(state.q)
    weight, modelled_weight = (
        joint_dynamics(tree, model.gravity_W).at(state.q).bias(zero) for tree in (rigid(model.tree), model.tree)
    )
    return effort + passive + weight - modelled_weight, np.maximum(largest, 0.0)


def _drive(body: int, effort: FloatArray, largest: FloatArray, client: int) -> None:
    for j in range(len(effort)):
        # The default gain of 0.1 would stop a tenth of the rate per step: stiction would creep.
        friction = {"targetVelocity": 0.0, "velocityGain": 1.0, "force": float(largest[j]), "physicsClientId": client}
        pybullet.setJointMotorControl2(body, j, pybullet.VELOCITY_CONTROL, **friction)
        torque = {"force": float(effort[j]), "physicsClientId": client}
        pybullet.setJointMotorControl2(body, j, pybullet.TORQUE_CONTROL, **torque)


def _state(body: int, joints: Sequence[int], client: int) -> FloatArray:
    """(2, j) positions and rates."""
    states = pybullet.getJointStates(body, joints, physicsClientId=client)
    return np.array([[s[0] for s in states], [s[1] for s in states]])


def _load(model: MechanismModel, client: int) -> int:
    pybullet.setGravity(*model.gravity_W.tolist(), physicsClientId=client)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mechanism.urdf"
        file.write_bytes(write_urdf(described(rigid(model.tree))).data)
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE  # Else the engine makes up its own.
        body = pybullet.loadURDF(str(file), useFixedBase=True, flags=flags, physicsClientId=client)
    off = {"linearDamping": 0.0, "angularDamping": 0.0, "physicsClientId": client}
    for j in range(-1, len(model.tree)):
        pybullet.changeDynamics(body, j, **off)
    for j in range(len(model.tree)):
        # Set here: a file's tensor that breaks the triangle inequality is silently taken as zero.
        moments, _ = principal_axes(rigid(model.tree)[j].inertia_J)
        held = {"localInertiaDiagonal": moments.tolist(), "jointDamping": 0.0, "physicsClientId": client}
        pybullet.changeDynamics(body, j, **held)
        # Revolute joints come with a motor that holds them.
        pybullet.setJointMotorControl2(body, j, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
    return body


def rigid(tree: Tree) -> Tree:
    """The tree without armatures and gravity factors: an armature becomes inertia of its link.

    Raises ValueError for an armature inside a chain, which would act on other joints.
    """
    return tuple(_rigid(tree, i) for i in range(len(tree)))


def _rigid(tree: Tree, i: int) -> Link:
    link = tree[i]
    if link.armature != 0.0 and (link.parent >= 0 or any(other.parent == i for other in tree)):
        raise ValueError(f"joint '{link.name}': an armature inside a chain has no rigid link that stands for it")
    plain = replace(link, armature=0.0, gravity_factor=1.0)
    if link.prismatic:
        return replace(plain, mass_kg=link.mass_kg + link.armature)
    return replace(plain, inertia_J=link.inertia_J + link.armature * np.eye(3))


def described(tree: Tree) -> RobotDescription:
    """The tree as a description: a base of 1 kg, a link per joint, no shapes.

    Inertial frames lie along the principal axes; `_load` sets the moments.
    """
    base = DescribedLink("base", (), Inertial(1.0, np.eye(4), np.eye(3)), "declared")
    links = [base, *(_described_link(link, i) for i, link in enumerate(tree))]
    joints = [_described_joint(link, i) for i, link in enumerate(tree)]
    return RobotDescription("mechanism", "urdf", tuple(links), tuple(joints), "base")


def _described_link(link: Link, i: int) -> DescribedLink:
    moments, quat_wxyz = principal_axes(link.inertia_J)
    inertial = Inertial(link.mass_kg, pose(matrix_of(quat_wxyz), link.com_J), np.diag(moments))
    return DescribedLink(f"link_{i}", (), inertial, "declared")


def _described_joint(link: Link, i: int) -> DescribedJoint:
    return DescribedJoint(
        name=f"{i}",
        kind="prismatic" if link.prismatic else "continuous",
        parent="base" if link.parent < 0 else f"link_{link.parent}",
        child=f"link_{i}",
        X_PC=link.X_PJ,
        axis_C=link.axis_J,
        limits=JointLimits(1.0, -1.0),  # PyBullet takes limits that are upside down as none.
        effort=_BOUNDLESS,
        velocity=_BOUNDLESS,
    )
