"""How far one joint of a mechanism can move from rest until links meet, by the triangles of their surfaces."""

from __future__ import annotations

from collections.abc import Mapping

import fcl
import numpy as np

from geom.mechanism_pose import link_motions
from schemas.arrays import FloatArray, IntArray
from schemas.mechanism import Mechanism, MechanismJoint

SEARCHED_STEPS = (
    64  # from rest to the furthest position looked at; a link that passes through a wall crosses it for its length
)
RANGE_BISECTIONS = 8  # of the step in which links meet
MOST_LINK_PAIRS = 256  # of links; of more the range is not looked for

Surface = tuple[FloatArray, IntArray]


def collision_free_range(
    mechanism: Mechanism, joint: MechanismJoint, surfaces: Mapping[str, Surface], furthest: float
) -> tuple[float | None, float | None]:
    """The least and greatest position (rad, m or source units) up to which no links meet that are apart at rest.

    `surfaces` are points (n, 3) and triangles (m, 3) of links by name, at rest in the frame of the mechanism.
    `furthest` is how far from rest either way is looked at; None: nothing is met that far. Other joints stay at rest,
    joints that follow this one move with it. Links whose surfaces cross at rest are left out.
    """
    models = {name: _model(*surface) for name, surface in surfaces.items() if len(surface[1])}
    at_rest = link_motions(mechanism, {})
    moved = link_motions(mechanism, {joint.name: joint.rest + furthest / SEARCHED_STEPS})
    moving = [name for name in models if not np.allclose(moved[name], at_rest[name], atol=1e-12)]
    pairs = [(a, b) for a in moving for b in models if b not in moving]
    if not 0 < len(pairs) <= MOST_LINK_PAIRS:
        return None, None

    def meets(position: float, of_pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
        motions = link_motions(mechanism, {joint.name: position})
        objects = {name: fcl.CollisionObject(models[name], _transform(motions[name])) for name in models}
        return [pair for pair in of_pairs if fcl.collide(objects[pair[0]], objects[pair[1]])]

    crossing = meets(joint.rest, pairs)
    apart = [pair for pair in pairs if pair not in crossing]

    def free_until(direction: float) -> float | None:
        step = direction * furthest / SEARCHED_STEPS
        for k in range(1, SEARCHED_STEPS + 1):
            if not meets(joint.rest + k * step, apart):
                continue
            free, met = (k - 1) * step, k * step
            for _ in range(RANGE_BISECTIONS):
                middle = 0.5 * (free + met)
                free, met = (free, middle) if meets(joint.rest + middle, apart) else (middle, met)
            return joint.rest + free
        return None

    return free_until(-1.0), free_until(1.0)


def _model(points: FloatArray, triangles: IntArray) -> fcl.BVHModel:
    model = fcl.BVHModel()
    model.beginModel(len(triangles), len(points))
    model.addSubModel(np.asarray(points, dtype=np.float64), np.asarray(triangles, dtype=np.int64))
    model.endModel()
    return model


def _transform(X: FloatArray) -> fcl.Transform:
    return fcl.Transform(X[:3, :3], X[:3, 3])
