"""The mechanism as its owner believes it, from the joint table of a measurement.

World: z up. Revolute axes are horizontal (along y); a link hangs along -z of its own frame at joint angle `zero_rad`.
Sliding joints move along x. Joints with a parent offset form a chain, others stand side by side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.measurement import Actuation, Joint, MeasurementSpec
from schemas.model import FloatArray
from sim.mechanism import Drive, MechanismModel
from sim.tree import Link, Tree

_LEAST_INERTIA = 1e-9


def build_mechanism(spec: MeasurementSpec) -> MechanismModel:
    """The declared model of a `mechanism` measurement with a joint table. Raises ValueError when it has none."""
    joints = spec.subject.joints
    if not joints:
        raise ValueError("the subject declares no joints")
    limits = [j.limits or (-np.inf, np.inf) for j in joints]
    return MechanismModel(
        tree=_tree(joints),
        gravity_W=np.array(spec.world.gravity_mps2),
        friction=np.array([j.friction for j in joints]),
        damping=np.array([j.damping for j in joints]),
        drive=_drive(spec.actuation, len(joints)),
        limits=np.array(limits, dtype=float),
    )


def _tree(joints: Sequence[Joint]) -> Tree:
    chained = any(j.parent_offset_m for j in joints)
    return tuple(_link(j, i - 1 if chained else -1) for i, j in enumerate(joints))


def _link(joint: Joint, parent: int) -> Link:
    X_PJ = np.eye(4)
    if joint.type == "prismatic":
        mass = joint.mass_kg or joint.inertia_kgm2 or 0.0
        return Link(joint.name, parent, True, np.array([1.0, 0.0, 0.0]), X_PJ, mass, np.zeros(3), np.zeros((3, 3)))
    load = joint.gravity_load
    mass = load.mass_kg if load else (joint.mass_kg or 0.0)
    lever = load.com_distance_m if load else 0.0
    about_axis = joint.inertia_kgm2 if joint.inertia_kgm2 is not None else mass * lever**2
    about_com = max(about_axis - mass * lever**2, _LEAST_INERTIA)
    X_PJ[:3, :3] = Rotation.from_rotvec([0.0, -(load.zero_rad if load else 0.0), 0.0]).as_matrix()
    X_PJ[2, 3] = -joint.parent_offset_m if parent >= 0 else 0.0
    return Link(
        name=joint.name,
        parent=parent,
        prismatic=False,
        axis_J=np.array([0.0, 1.0, 0.0]),
        X_PJ=X_PJ,
        mass_kg=mass,
        com_J=np.array([0.0, 0.0, -lever]),
        inertia_J=np.diag([about_com, about_com, about_com]),
    )


def _drive(actuation: Actuation, joints: int) -> Drive:
    def per_joint(values: float | tuple[float, ...]) -> FloatArray:
        return np.broadcast_to(np.asarray(values, dtype=float), (joints,))

    return Drive(
        type=actuation.type,
        kp=per_joint(actuation.kp),
        kd=per_joint(actuation.kd),
        effort_limit=actuation.effort_limit,
        effort_per_unit=actuation.effort_per_unit,
    )
