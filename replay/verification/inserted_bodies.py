"""Rigid bodies and poses X_WA of the objects of a variant, reread from their packages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geom.pose import pose_from_quat
from runtime_plan.bodies import PhysicalBody, physical_body
from schemas.arrays import FloatArray
from schemas.physics import RigidBody
from schemas.replay.documents import Inserted
from schemas.scene.runtime_plan import PlanBody


@dataclass(frozen=True)
class InsertedBody:
    """An inserted object: body in its asset frame A, X_WA (4, 4)."""

    stated: Inserted
    body: RigidBody
    X_WA: FloatArray


def inserted_body(inserted: Inserted, packages: Path | None) -> InsertedBody:
    """The body at its pose. Raises FileNotFoundError where its package is not below `packages`."""
    X_WA = pose_from_quat(np.array(inserted.quat_wxyz), inserted.position_m)
    return InsertedBody(inserted, as_packaged(inserted, packages).body, X_WA)


def as_packaged(inserted: Inserted, packages: Path | None) -> PhysicalBody:
    """The body at its scale with its density, without the material that was drawn for it. Raises as above."""
    asset = PlanBody(
        asset_id=inserted.asset_id,
        package=inserted.package,
        scale=inserted.scale,
        mass_kg=inserted.mass_kg,
        primitive=inserted.primitive,
        stances=(),
    )
    return physical_body(asset, packages)
