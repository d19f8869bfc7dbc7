"""Does every inserted object stay where it was put, with the robots absent?"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from geom.pose import angle_between, quat_of
from replay.recording.episode import Episode
from replay.verification.inserted_bodies import InsertedBody
from schemas.model import FloatArray
from schemas.physics import CollisionShape, MassProperties, RigidBody
from schemas.replay import Moved
from sim.port import PlacedBody
from usdio.write.primitive import CONTACT

Settle = Callable[[Sequence[PlacedBody], float], FloatArray]  # `sim.bullet.scene.settle_scene`, chosen by cli
DURATION_S = 1.0
MOST_MOVED_M, MOST_TURNED_DEG = 0.002, 2.0
_NO_MASS = MassProperties(1.0, np.zeros(3), np.eye(3))  # What does not move needs none.


def moved_when_let_go(episode: Episode, inserted: Sequence[InsertedBody], settle: Settle) -> tuple[Moved, ...]:
    """One row for each inserted object: let go among the fixtures and the recorded objects at their first pose."""
    stood = [(fixture.shapes, fixture.X_WB) for fixture in episode.fixtures]
    stood += [(body.shapes, body.X_WB[0]) for body in episode.objects]
    things = [PlacedBody(_fixed(shapes), X_WB, moves=False) for shapes, X_WB in stood if shapes]
    things += [PlacedBody(one.body, one.X_WA, moves=True) for one in inserted]
    ends = settle(things, DURATION_S)[len(things) - len(inserted) :]
    return tuple(_moved(one, X_WA) for one, X_WA in zip(inserted, ends, strict=True))


def _fixed(shapes: tuple[CollisionShape, ...]) -> RigidBody:
    return RigidBody("fixed", shapes, _NO_MASS, CONTACT)


def _moved(one: InsertedBody, X_WA: FloatArray) -> Moved:
    moved_m = math.dist(X_WA[:3, 3], one.X_WA[:3, 3])
    turned_deg = math.degrees(float(angle_between(quat_of(X_WA[:3, :3]), quat_of(one.X_WA[:3, :3]))))
    stayed = moved_m < MOST_MOVED_M and turned_deg < MOST_TURNED_DEG
    return Moved(name=one.stated.name, moved_m=moved_m, turned_deg=turned_deg, stayed=stayed)
