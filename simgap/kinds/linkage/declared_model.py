"""The declared linkage of a measurement, built from the URDF of its subject; SI."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.measurement import MeasurementSpec
from sim.dynamics.linkage_rollout import LinkageModel
from simgap.kinds.free_body.declared_model import body_of
from simgap.kinds.mechanism.declared_model import urdf_mechanism
from simgap.recording.reading.subject import read_subject


def build_linkage(spec: MeasurementSpec, root: Path) -> LinkageModel:
    """The declared model of a `free_body` measurement with joints; joints in the order of `movable_joints`.

    Raises ValueError for a subject that is no URDF, and for links without mass.
    """
    urdf = read_subject(spec.subject, root)
    base = body_of(spec, urdf.links[0])
    joints = urdf_mechanism(urdf, base.gravity_W, np.eye(4))
    shapes = tuple(urdf.links[joint.child].shapes for joint in urdf.joints)
    return LinkageModel(base, joints, shapes, tuple(link.name for link in urdf.links))
