"""Settle the inserted objects among fixtures and recorded objects, without robots: how far (m, deg) does each move?"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from geom.pose import angle_between, quat_of
from replay.recording.episode import Episode
from replay.verification.inserted_bodies import InsertedBody
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, MassProperties, RigidBody
from schemas.replay.documents import Moved
from sim.port import PlacedBody
from usdio.write.primitive import CONTACT

Settle = Callable[[Sequence[PlacedBody], float], FloatArray]  # `sim.bullet.scene.settle_scene`, chosen by cli
DURATION_S = 1.0
MOST_MOVED_M, MOST_TURNED_DEG = 0.002, 2.0
_NO_MASS = MassProperties(1.0, np.zeros(3), np.eye(3))  # Static bodies need none.


def settling_motion(episode: Episode, inserted: Sequence[InsertedBody], settle: Settle) -> tuple[Moved, ...]:
    """One row for each inserted object: released among the fixtures and the recorded objects at their first pose."""
    fixed = [(fixture.shapes, fixture.X_WB) for fixture in episode.fixtures]
    fixed += [(body.shapes, body.X_WB[0]) for body in episode.objects]
    bodies = [PlacedBody(_fixed(shapes), X_WB, moves=False) for shapes, X_WB in fixed if shapes]
    bodies += [PlacedBody(inserted_body.body, inserted_body.X_WA, moves=True) for inserted_body in inserted]
    ends = settle(bodies, DURATION_S)[len(bodies) - len(inserted) :]
    return tuple(_motion(inserted_body, X_WA) for inserted_body, X_WA in zip(inserted, ends, strict=True))


def _fixed(shapes: tuple[CollisionShape, ...]) -> RigidBody:
    return RigidBody("fixed", shapes, _NO_MASS, CONTACT)


def _motion(inserted: InsertedBody, X_WA: FloatArray) -> Moved:
    moved_m = math.dist(X_WA[:3, 3], inserted.X_WA[:3, 3])
    turned_deg = math.degrees(float(angle_between(quat_of(X_WA[:3, :3]), quat_of(inserted.X_WA[:3, :3]))))
    stayed = moved_m < MOST_MOVED_M and turned_deg < MOST_TURNED_DEG
    return Moved(name=inserted.stated.name, moved_m=moved_m, turned_deg=turned_deg, stayed=stayed)
