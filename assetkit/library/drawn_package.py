"""The model of a package to draw, in the frame in which its USD is re-read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from assetkit.library.preview_worker import first_model
from geom.convex.placement import moved_shape
from geom.convex.support_function import surface
from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput
from schemas.evidence import default
from schemas.model import Mesh, Model
from schemas.physics import CollisionShape
from usdio.reread.body import RereadPackage

ASTRAY = 0.01  # of the size: boxes around both that differ by more lie in different frames


def drawn_package(main_file: Path, content: RereadPackage) -> Model:
    """The visible meshes with their materials, or, where these lie in another frame or have other joints, as in USD of
    other makers, the colliders in plain grey.
    """
    try:
        model = first_model(main_file)
    except InvalidInput:
        return _colliders(content)
    return model if _agrees(model, content) else _colliders(content)


def _agrees(model: Model, content: RereadPackage) -> bool:
    points = np.concatenate([mesh.points for mesh in model.meshes])
    if not len(points) or not len(content.visual_points):
        return False
    ends = [np.stack([p.min(axis=0), p.max(axis=0)]) for p in (points, content.visual_points)]
    same_place = np.abs(ends[0] - ends[1]).max() <= ASTRAY * float(np.linalg.norm(ends[1][1] - ends[1][0]))
    return bool(same_place) and _joints(model) == (
        set[str]() if content.mechanism is None else {joint.name for joint in content.mechanism.joints}
    )


def _joints(model: Model) -> set[str]:
    return set() if model.mechanism is None else {joint.name for joint in model.mechanism.joints}


def _colliders(content: RereadPackage) -> Model:
    if content.mechanism is None:
        meshes = [_mesh(shape, "", k) for k, shape in enumerate(content.body.shapes)]
    else:
        origins: dict[str, FloatArray] = {link.name: pose(None, link.origin) for link in content.mechanism.links}
        placed = [(moved_shape(s, origins[body.name]), body.name) for body in content.links for s in body.shapes]
        meshes = [_mesh(shape, link, k) for k, (shape, link) in enumerate(placed)]
    return Model(tuple(meshes), (), (), (), default(1.0), default("z"), mechanism=content.mechanism)


def _mesh(shape: CollisionShape, link: str, number: int) -> Mesh:
    points, triangles = surface(shape)
    return Mesh(f"collider {number}", points, triangles.astype(np.int32), id=f"collider_{number}", link=link)
