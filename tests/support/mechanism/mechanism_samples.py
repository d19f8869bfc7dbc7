"""A small articulated package: a case with a door, a tray that follows it, and a knob on the door."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.package import LinkBody, PackageContent
from schemas.physics import MassProperties
from tests.support.package_samples import box_mesh, content, hull_shape, model

TILTED = np.array([0.6, 0.0, -0.8])
LINKS = (
    ("case", (0.0, 0.0, 0.0)),
    ("door", (0.05, 0.04, 0.03)),
    ("tray", (0.0, 0.0, 0.03)),
    ("knob", (0.06, 0.0, 0.03)),
)
JOINTS = (
    MechanismJoint(
        "hinge",
        "revolute",
        "case",
        "door",
        np.array([0.05, 0.04, 0.03]),
        np.array([0.0, 0.0, -1.0]),
        rest=0.3,
        limits=(-0.1, 2.0),
        effort=5.0,
        damping=0.2,
        friction=0.01,
        armature=0.002,
        velocity=3.0,
        stiffness=0.4,
        spring_rest=0.1,
    ),
    MechanismJoint(
        "slide",
        "prismatic",
        "case",
        "tray",
        np.array([0.0, 0.0, 0.03]),
        TILTED,
        rest=0.02,
        limits=(0.0, 0.15),
        coupling=JointCoupling("hinge", 0.05, 0.005),
    ),
    MechanismJoint("turn", "continuous", "door", "knob", np.array([0.06, 0.0, 0.03]), np.array([1.0, 0.0, 0.0])),
)


def articulated() -> PackageContent:
    meshes = [box_mesh((0.04, 0.03, 0.02), name, np.array(origin), link=name) for name, origin in LINKS]
    plain = content(model(meshes), tuple(hull_shape(mesh) for mesh in meshes))
    mechanism = Mechanism(tuple(MechanismLink(name, np.array(origin)) for name, origin in LINKS), JOINTS)
    bodies = tuple(
        LinkBody(name, (i,), MassProperties(0.1 + i, np.array(origin) + 0.001, np.diag([2e-5, 3e-5, 4e-5])))
        for i, (name, origin) in enumerate(LINKS)
    )
    return replace(plain, mechanism=mechanism, links=bodies, filtered_pairs=(("door", "tray"),))
