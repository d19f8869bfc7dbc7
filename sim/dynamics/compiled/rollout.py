"""From a model, windows and laws to the numbers of a kernel, and from it to positions and rates.

Input and output are those of `sim.dynamics.mechanism.rollout`, whose NumPy form is the reference and the fallback.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from schemas.arrays import FloatArray, IntArray
from sim.dynamics.compiled.coupled_joints import PLANAR, TREE, roll_coupled
from sim.dynamics.compiled.inputs import (
    EFFORT_DRIVE,
    EFFORT_LAW,
    FRICTION_LAW,
    MOST_MEMORY,
    MOST_VALUES,
    NO_DRIVE,
    PD_DRIVE,
    TORQUE_LAW,
    Inputs,
    address_of,
)
from sim.dynamics.compiled.separate_joints import roll_separate
from sim.dynamics.hooks import EffortMap, JointFriction, JointTorque, StepHook
from sim.dynamics.joint_dynamics import CoupledJoints, PlanarChain, SeparateJoints, joint_dynamics

if TYPE_CHECKING:
    from sim.dynamics.mechanism import Law, MechanismModel, Windows

_DRIVES = {"none": NO_DRIVE, "effort": EFFORT_DRIVE, "position_pd": PD_DRIVE}
_KINDS = {EffortMap: EFFORT_LAW, JointTorque: TORQUE_LAW, JointFriction: FRICTION_LAW}


def rollout(
    model: MechanismModel, windows: Windows, laws: Sequence[Law], steps: IntArray, typical_s: FloatArray, supply: str
) -> tuple[FloatArray, FloatArray]:
    """Positions and rates (w, k, j) of windows whose intervals have `steps` (k - 1,) of about `typical_s` / steps."""
    worlds, stamps = windows.t_s.shape
    joints = len(model.tree)
    drive = model.drive
    none = np.zeros((0, 0, 0))
    values, memory = np.zeros((len(laws), MOST_VALUES)), np.zeros((len(laws), MOST_MEMORY))
    kinds, places, addresses = (np.zeros(len(laws), dtype=np.int64) for _ in range(3))
    for i, law in enumerate(laws):
        hook = law.hook
        assert isinstance(hook, EffortMap | JointTorque | JointFriction)
        values[i, : len(hook.names)] = [law.params[name] for name in hook.names]
        memory[i, : hook.memory] = np.nan
        kinds[i], places[i], addresses[i] = _KINDS[type(hook)], law.joint, address_of(hook.law)
    by_load = any(isinstance(law.hook, JointFriction) and law.hook.by_load for law in laws)
    friction = (kinds == FRICTION_LAW).any() or bool(model.friction.any())
    volts = windows.aux.get(supply)
    form = joint_dynamics(model.tree, model.gravity_W)
    given = Inputs(
        np.ascontiguousarray(windows.t_s, dtype=float),
        steps.astype(np.int64),
        np.ascontiguousarray(typical_s, dtype=float),
        np.ascontiguousarray(windows.q0, dtype=float),
        np.ascontiguousarray(windows.qd0, dtype=float),
        _inputs(windows.command, windows.effort, drive.type, none),
        _DRIVES[drive.type] if _has_input(windows, drive.type) else NO_DRIVE,
        np.broadcast_to(np.asarray(drive.kp, dtype=float), joints).copy(),
        np.broadcast_to(np.asarray(drive.kd, dtype=float), joints).copy(),
        float(drive.effort_per_unit),
        np.inf if drive.effort_limit is None else float(drive.effort_limit),
        np.full((worlds, stamps), np.nan) if volts is None else np.ascontiguousarray(volts, dtype=float),
        np.broadcast_to(np.asarray(model.friction, dtype=float), joints).copy(),
        np.broadcast_to(np.asarray(model.damping, dtype=float), joints).copy(),
        addresses,
        kinds,
        places,
        values,
        memory,
        bool(by_load),
        bool(friction),
    )
    if isinstance(form, SeparateJoints):
        remembers = any(law.hook.memory for law in laws if isinstance(law.hook, StepHook))
        return roll_separate(given, remembers, _separate_numbers(form))
    return roll_coupled(given, *_numbers(form, joints))


def _has_input(windows: Windows, drive_type: str) -> bool:
    return (windows.effort if drive_type == "effort" else windows.command) is not None


def _inputs(command: FloatArray | None, effort: FloatArray | None, drive_type: str, none: FloatArray) -> FloatArray:
    chosen = effort if drive_type == "effort" else command
    return none if chosen is None else np.ascontiguousarray(chosen, dtype=float)


def _separate_numbers(form: SeparateJoints) -> FloatArray:
    """(9, j) inertia, gravity's effort (level, along, across), and the terms of the bearing load."""
    rows = (form.inertia, form.level, form.along, form.across, form.weight2, *form.pull, form.spin)
    return np.array(rows, dtype=float)


def _numbers(form: Any, joints: int) -> tuple[int, Any, Any]:
    """The form of the dynamics, and its numbers: a planar chain, a tree."""
    places = np.zeros(joints, dtype=complex), np.zeros(joints)  # for directions and squared rates of links
    planar = (
        np.zeros((5, joints)),
        np.zeros((2, joints, joints), dtype=complex),
        np.zeros(joints, dtype=complex),
        0j,
        0.0,
        *places,
    )
    tree = (
        np.zeros(joints, dtype=np.int64),
        np.zeros(joints, dtype=np.bool_),
        np.zeros((joints, 3)),
        np.zeros((joints, 3, 3)),
        np.zeros((joints, 3)),
        np.zeros((3, joints)),
        np.zeros((joints, 3)),
        np.zeros((joints, 3, 3)),
        np.zeros(3),
    )
    if isinstance(form, PlanarChain):
        rows = (form.zero, form.turning, form.armature, form.outboard_mass, np.zeros(joints))
        matrices = np.ascontiguousarray(np.stack([form.coupled, form.outboard]))
        numbers = (np.array(rows, dtype=float), matrices, form.weight, complex(form.gravity), form.gravity_y, *places)
        return PLANAR, numbers, tree
    assert isinstance(form, CoupledJoints)
    links = form.tree
    numbers = (
        np.array([link.parent for link in links], dtype=np.int64),
        np.array([link.prismatic for link in links], dtype=np.bool_),
        np.array([link.axis_J for link in links], dtype=float),
        np.array([link.X_PJ[:3, :3] for link in links], dtype=float),
        np.array([link.X_PJ[:3, 3] for link in links], dtype=float),
        np.array([[link.mass_kg, link.armature, link.gravity_factor] for link in links], dtype=float).T.copy(),
        np.array([link.com_J for link in links], dtype=float),
        np.array([link.inertia_J for link in links], dtype=float),
        np.asarray(form.gravity_W, dtype=float).copy(),
    )
    return TREE, planar, numbers
