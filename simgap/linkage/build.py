"""The jointed body as its owner believes it, from the URDF of a measurement's subject."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.measurement import MeasurementSpec
from sim.linkage_replay import LinkageModel
from sim.mechanism import MechanismModel
from sim.tree import Link
from simgap.free_body.build import body_of
from simgap.reading.subject import read_subject


def build_linkage(spec: MeasurementSpec, root: Path) -> LinkageModel:
    """The declared model of a `free_body` measurement with joints; joints in the order of `movable_joints`.

    Raises ValueError for a subject that is no URDF, and for links without mass.
    """
    urdf = read_subject(spec.subject, root)
    base = body_of(spec, urdf.links[0])
    tree, shapes = [], []
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
                X_PJ=joint.X_PJ,
                mass_kg=link.mass.mass_kg,
                com_J=link.mass.centre_of_mass_m,
                inertia_J=link.mass.inertia_kgm2,
            )
        )
        shapes.append(link.shapes)
    joints = MechanismModel(
        tree=tuple(tree),
        gravity_W=base.gravity_W,
        friction=np.array([j.friction for j in urdf.joints]),
        damping=np.array([j.damping for j in urdf.joints]),
        limits=np.array([j.limits or (-np.inf, np.inf) for j in urdf.joints]),
    )
    return LinkageModel(base, joints, tuple(shapes), tuple(link.name for link in urdf.links))
