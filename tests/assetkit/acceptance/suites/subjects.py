"""Subjects for tests of suites, without a package on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from assetkit.acceptance.suites.suite import Subject
from schemas.affordances import Grasp
from schemas.asset import Role
from schemas.physics import RigidBody
from usdio.reread.body import RereadPackage


def subject(body: RigidBody, *roles: Role, grasps: tuple[Grasp, ...] = ()) -> Subject:
    """A rigid object with these roles and grasps on record, and no bounds."""
    content = RereadPackage(body, (body.contact,) * len(body.shapes), np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    return Subject(Path("thing.usda"), content, roles=roles, grasps=grasps)
