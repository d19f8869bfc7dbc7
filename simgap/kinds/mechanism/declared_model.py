"""The declared mechanism of a measurement, built from its joint table or its URDF; SI.

World: z up. Revolute axes are horizontal (along y); a link hangs along -z of its own frame at joint angle `zero_rad`.
Sliding joints move along x. Joints with a parent offset form a chain, others stand side by side. The root of a URDF
stands still, its frame is the world's unless `base_pose` says otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from geom.pose import pose_from_quat
from schemas.arrays import FloatArray
from schemas.measurement import Actuation, Joint, MeasurementSpec
from sim.dynamics.mechanism import Drive, MechanismModel
from sim.dynamics.tree import Link, Tree
from simgap.recording.reading.subject import INERTIA_ROUNDING, read_subject
from simgap.recording.reading.urdf import SubjectModel


def build_mechanism(spec: MeasurementSpec, root: Path) -> MechanismModel:
    """The declared model of a `mechanism` measurement. Raises ValueError for a subject without joints or mass."""
    joints = spec.subject.joints
    if not joints:
        urdf = read_subject(spec.subject, root)
        model = urdf_mechanism(urdf, np.array(spec.world.gravity_mps2), _base_pose(spec))
        return replace(model, drive=_drive(spec.actuation, len(model.tree)))
    limits = [j.limits or (-np.inf, np.inf) for j in joints]
    return MechanismModel(
        tree=_tree(joints),
        gravity_W=np.array(spec.world.gravity_mps2),
        friction=np.array([j.friction for j in joints]),
        damping=np.array([j.damping for j in joints]),
        drive=_drive(spec.actuation, len(joints)),
        limits=np.array(limits, dtype=float),
    )


def urdf_mechanism(urdf: SubjectModel, gravity_W: FloatArray, X_WB: FloatArray) -> MechanismModel:
    """Links and joints of a URDF, its root at X_WB (4, 4). Raises ValueError for a link without mass."""
    if not urdf.joints:
        raise ValueError("the URDF has no movable joints")
    tree = []
    for joint in urdf.joints:
        link = urdf.links[joint.child]
        if link.mass is None:
            raise ValueError(f"link '{link.name}' has no mass")
        tree.append(
            Link(
                name=joint.name,
                parent=joint.parent - 1,
                prismatic=joint.prismatic,
                axis_J=joint.axis_J,
                X_PJ=X_WB @ joint.X_PJ if joint.parent == 0 else joint.X_PJ,
                mass_kg=link.mass.mass_kg,
                com_J=link.mass.centre_of_mass_m,
                inertia_J=link.mass.inertia_kgm2,
            )
        )
    return MechanismModel(
        tree=tuple(tree),
        gravity_W=gravity_W,
        friction=np.array([j.friction for j in urdf.joints]),
        damping=np.array([j.damping for j in urdf.joints]),
        limits=np.array([j.limits or (-np.inf, np.inf) for j in urdf.joints]),
    )


def _base_pose(spec: MeasurementSpec) -> FloatArray:
    """(4, 4) from x, y, z and a quaternion wxyz. Raises ValueError for another number of values."""
    given = spec.subject.base_pose
    if given is None:
        return np.eye(4)
    if len(given) != 7:
        raise ValueError(f"base_pose needs 7 numbers (x, y, z, qw, qx, qy, qz), found {len(given)}")
    return pose_from_quat(np.array(given[3:]), (given[0], given[1], given[2]))


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
    about_com = _about_com(joint)
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


def _about_com(joint: Joint) -> float:
    """Inertia of a turning link about its mass centre, kg m2; 0 for a point mass. Raises ValueError below that."""
    least = joint.gravity_load.inertia_kgm2 if joint.gravity_load is not None else 0.0
    about_axis = joint.inertia_kgm2 if joint.inertia_kgm2 is not None else least
    if about_axis <= 0.0 or about_axis < least * (1.0 - INERTIA_ROUNDING):
        raise ValueError(f"joint '{joint.name}': {about_axis:g} kg m2 about its axis, its load alone has {least:g}")
    return max(about_axis - least, 0.0)  # Only rounding is left below 0.


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
