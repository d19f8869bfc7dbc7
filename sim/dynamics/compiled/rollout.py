"""From a model, windows and laws to the numbers of a kernel, and from it to positions and rates.

Input and output are those of `sim.dynamics.mechanism.rollout`, whose NumPy form is the reference and the fallback.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from schemas.arrays import FloatArray, IntArray
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
from sim.dynamics.compiled.planar_chain import roll_planar_chain
from sim.dynamics.compiled.separate_joints import roll_separate
from sim.dynamics.compiled.tree import roll_tree
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
    if isinstance(form, PlanarChain):
        return roll_planar_chain(given, *_planar_numbers(form))
    assert isinstance(form, CoupledJoints)
    return roll_tree(given, _tree_numbers(form))


def _has_input(windows: Windows, drive_type: str) -> bool:
    return (windows.effort if drive_type == "effort" else windows.command) is not None


def _inputs(command: FloatArray | None, effort: FloatArray | None, drive_type: str, none: FloatArray) -> FloatArray:
    chosen = effort if drive_type == "effort" else command
    return none if chosen is None else np.ascontiguousarray(chosen, dtype=float)


def _separate_numbers(form: SeparateJoints) -> FloatArray:
    """(9, j) inertia, gravity's effort (level, along, across), and the terms of the bearing load."""
    rows = (form.inertia, form.level, form.along, form.across, form.weight2, *form.pull, form.spin)
    return np.array(rows, dtype=float)


def _planar_numbers(form: PlanarChain) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The numbers of a planar chain, complex ones as real and imaginary parts; see `roll_planar_chain`."""
    rows = (form.zero, form.turning, form.armature, form.outboard_mass, form.weight.real, form.weight.imag)
    return (
        np.array(rows, dtype=float),
        np.stack([form.coupled.real, form.coupled.imag]),
        np.stack([form.outboard.real, form.outboard.imag]),
        np.array([form.gravity.real, form.gravity.imag, form.gravity_y]),
    )


def _tree_numbers(form: CoupledJoints) -> tuple[Any, ...]:
    """The numbers of the links of a tree; see `roll_tree`."""
    links = form.tree
    return (
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
