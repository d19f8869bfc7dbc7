"""Subjects for tests of suites, without a package on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from assetkit.acceptance.suites.suite import Subject
from schemas.affordances import Grasp, Region
from schemas.anchors import Anchor
from schemas.asset import Role
from schemas.physics import RigidBody
from usdio.reread.body import RereadPackage


def subject(
    body: RigidBody,
    *roles: Role,
    grasps: tuple[Grasp, ...] = (),
    regions: tuple[Region, ...] = (),
    anchors: tuple[Anchor, ...] = (),
) -> Subject:
    """A rigid object with these roles, grasps, regions and anchors on record, and no bounds."""
    content = RereadPackage(body, (body.contact,) * len(body.shapes), np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    return Subject(Path("thing.usda"), content, roles=roles, grasps=grasps, regions=regions, anchors=anchors)
