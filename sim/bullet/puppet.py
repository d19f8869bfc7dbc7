"""Moves objects without a robot and records what happens: poses and contacts of all bodies at even stamps.

A carried object follows straight lines between poses, exactly, and pushes what is in its way; let go, it falls.
In the log a hand with two fingers carries it, so that tasks see when it is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation, Slerp

from schemas.arrays import FloatArray
from schemas.physics import RigidBody
from schemas.task.state_log import GripperParts, StateLog
from sim.bullet.resets import BulletResets
from sim.bullet.world import STEP_S, private_client

RATE_HZ = 30.0
TOUCH_M = 0.0005  # contacts of the engine are kept within this
HAND = GripperParts("hand", "hand", ("hand/left", "hand/right"))
_PARKED = (0.0, 0.0, 2.0)  # the hand, while it carries nothing (m)


@dataclass(frozen=True)
class Carry:
    """Takes an object through poses X_WA (k, 4, 4) in `duration_s`, evenly, and lets it go unless `hold`."""

    name: str
    poses_WA: FloatArray
    duration_s: float
    hold: bool = False


@dataclass(frozen=True)
class Wait:
    """Nothing is moved; what was held stays held, and still."""

    duration_s: float


@dataclass
class _Recorder:
    """Rows of the log so far."""

    t_s: list[float] = field(default_factory=list[float])
    poses_WA: list[FloatArray] = field(default_factory=list[FloatArray])
    pairs: list[frozenset[tuple[str, str]]] = field(default_factory=list[frozenset[tuple[str, str]]])


def puppet_log(
    bodies: Sequence[tuple[str, RigidBody, FloatArray, bool]], script: Sequence[Carry | Wait], rate_hz: float = RATE_HZ
) -> StateLog:
    """The log of a script in a world of bodies (name, body, X_WA (4, 4) at first, whether it moves)."""
    names = [name for name, *_ in bodies]
    with private_client() as client:
        world = BulletResets(client)
        for _, body, X_WA, moves in bodies:
            world.set_pose(world.add(body, moves), X_WA)
        rows, steps_per_row, step = _Recorder(), max(round(1.0 / (rate_hz * STEP_S)), 1), 0
        held: tuple[str, FloatArray] | None = None
        for action in script:
            count = max(round(action.duration_s / STEP_S), 1)
            path = _path(action, count) if isinstance(action, Carry) else None
            for k in range(count):
                if path is not None and isinstance(action, Carry):
                    held = action.name, path[k]
                if held is not None:
                    world.set_pose(names.index(held[0]), held[1])
                if step % steps_per_row == 0:
                    _record(rows, world, names, client, step * STEP_S, None if held is None else held[0])
                world.run(STEP_S)
                step += 1
            if isinstance(action, Carry) and not action.hold:
                held = None
        _record(rows, world, names, client, step * STEP_S, None if held is None else held[0])
    return _log(rows, names)


def _path(action: Carry, count: int) -> FloatArray:
    """(count, 4, 4) poses on the way, the last one reached at the end."""
    share = np.linspace(0.0, len(action.poses_WA) - 1.0, count)
    knots = np.arange(len(action.poses_WA))
    path = np.tile(np.eye(4), (count, 1, 1))
    for axis in range(3):
        path[:, axis, 3] = np.interp(share, knots, action.poses_WA[:, axis, 3])
    if len(action.poses_WA) > 1:
        path[:, :3, :3] = Slerp(knots, Rotation.from_matrix(action.poses_WA[:, :3, :3]))(share).as_matrix()
    else:
        path[:, :3, :3] = action.poses_WA[0, :3, :3]
    return path


def _record(
    rows: _Recorder, world: BulletResets, names: Sequence[str], client: int, t_s: float, held: str | None
) -> None:
    poses = world.poses()
    hand = np.eye(4)
    hand[:3, 3] = _PARKED if held is None else poses[names.index(held)][:3, 3]
    pybullet.performCollisionDetection(physicsClientId=client)
    handles = {world.handle(k): name for k, name in enumerate(names)}
    points = pybullet.getContactPoints(physicsClientId=client) or ()
    pairs = {tuple(sorted((handles[p[1]], handles[p[2]]))) for p in points if p[8] <= TOUCH_M}
    if held is not None:
        pairs |= {(finger, held) for finger in HAND.fingers}
    rows.t_s.append(t_s)
    rows.poses_WA.append(np.concatenate([poses, np.tile(hand, (3, 1, 1))]))
    rows.pairs.append(frozenset((a, b) for a, b in pairs))


def _log(rows: _Recorder, names: Sequence[str]) -> StateLog:
    poses = np.stack(rows.poses_WA)
    pairs = tuple(sorted(frozenset[tuple[str, str]]().union(*rows.pairs)))
    quats = Rotation.from_matrix(poses[..., :3, :3].reshape(-1, 3, 3)).as_quat(scalar_first=True)
    return StateLog(
        t_s=np.array(rows.t_s),
        bodies=(*names, HAND.palm, *HAND.fingers),
        position_m=np.ascontiguousarray(poses[..., :3, 3]),
        quat_wxyz=quats.reshape(*poses.shape[:2], 4),
        contact_pairs=pairs,
        touching=np.array([[pair in row for pair in pairs] for row in rows.pairs], dtype=bool).reshape(-1, len(pairs)),
        grippers=(HAND,),
    )
