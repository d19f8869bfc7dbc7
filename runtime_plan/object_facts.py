"""Facts of an object for judges of tasks, from its record and its collision shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.convex.shape_corners import shape_corners
from schemas.anchors import ContainmentVolume, SupportSurface
from schemas.asset import AssetRecord
from schemas.physics import RigidBody
from schemas.task.scene_facts import ObjectFacts

KNOWN = 0.5  # confidence from which on a category or colour counts as an attribute


def object_facts(name: str, body: RigidBody, record: AssetRecord, tags: Sequence[str] = ()) -> ObjectFacts:
    """The facts of a rigid object: corners of its shapes, its anchors, its category and main colour as attributes."""
    anchors = [anchor.value for anchor in record.anchors]
    attributes: dict[str, str] = {}
    category = record.semantics.category
    if category.confidence >= KNOWN:
        attributes["category"] = category.value
    return ObjectFacts(
        name=name,
        points_m=np.concatenate([shape_corners(shape) for shape in body.shapes]),
        body=name,
        volumes=tuple(a for a in anchors if isinstance(a, ContainmentVolume) and a.link is None),
        surfaces=tuple(a for a in anchors if isinstance(a, SupportSurface) and a.link is None),
        tags=tuple(sorted({*tags, *(str(role.value) for role in record.semantics.roles)})),
        attributes=attributes,
    )
