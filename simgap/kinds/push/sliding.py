"""Quasi-static pushing at a point: twist of the body and pushing force, from an ellipsoidal limit surface.

The wrench lies on the limit surface, the twist along its normal (Goyal, Ruina, Papadopoulos, Wear 143, 1991); the
contact sticks while its force is inside the friction cone, else it slides along the edge (Lynch, Maekawa, Tanie,
IROS 1992). No speed enters: a path pushed twice as fast gives the same motion.
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from simgap.kinds.push.footprint import nearest
from simgap.kinds.push.model import PushModel


def simulate_pushes(model: PushModel, start: FloatArray, tips: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses (n, s, 3) as x, y, yaw and forces (n, s, 2) on the body along tip paths (n, s, 2), all in world axes.

    start (n, 3) is the pose at the first row. Between rows the tip moves straight; a tip that has gone in moves the
    body out along the normal.
    """
    pose = np.array(start, dtype=float)
    poses, forces = [pose.copy()], [np.zeros((len(pose), 2))]
    for k in range(1, tips.shape[1]):
        move, force = _step(model, pose, tips[:, k - 1], tips[:, k])
        pose = pose + move
        poses.append(pose.copy())
        forces.append(force)
    return np.stack(poses, axis=1), np.stack(forces, axis=1)


def _step(model: PushModel, pose: FloatArray, before: FloatArray, after: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Change of pose (n, 3) and force (n, 2) of one short move of the tip, world axes."""
    turn = plane_rotations(pose[:, 2])
    tip = np.einsum("nji,nj->ni", turn, after - pose[:, :2])
    moved = np.einsum("nji,nj->ni", turn, after - before)
    distance, place, outward = nearest(model.outline, tip)
    depth = model.standoff_m - distance
    touching = depth > 0.0
    inward = -outward
    along = np.stack([-inward[:, 1], inward[:, 0]], axis=1)
    G = contact_map(place, model.body.com_B[:2])  # (n, 3, 2): force at the contact to wrench about the mass centre
    compliance = model.axes**-2
    K = np.einsum("nia,i,nib->nab", G, compliance, G)
    wanted = depth[:, None] * inward + (moved * along).sum(axis=1, keepdims=True) * along
    stick = np.linalg.solve(K, wanted[..., None])[..., 0]
    normal, tangential = (stick * inward).sum(axis=1), (stick * along).sum(axis=1)
    mu = model.pusher_friction
    slips = np.abs(tangential) > mu * np.maximum(normal, 0.0)
    edge = inward + mu * np.sign(tangential)[:, None] * along
    yielding = np.einsum("na,nab,nb->n", inward, K, edge)
    # A cone edge that pulls the body towards the tip cannot be: the contact then sticks.
    possible = yielding > 1e-12
    slide = edge * (depth / np.where(possible, yielding, 1.0))[:, None]
    force = np.where((slips & possible)[:, None], slide, stick) * touching[:, None]
    wrench = np.einsum("nia,na->ni", G, force)
    twist = compliance * wrench  # of the mass centre, body axes
    c = model.body.com_B[:2]
    origin = twist[:, :2] - twist[:, 2:] * np.array([-c[1], c[0]])
    size = np.sqrt((compliance * wrench**2).sum(axis=1))
    force = force * np.where(size > 0.0, model.largest_N / np.where(size > 0.0, size, 1.0), 0.0)[:, None]
    move = np.concatenate([np.einsum("nij,nj->ni", turn, origin), twist[:, 2:]], axis=1)
    return move, np.einsum("nij,nj->ni", turn, force)


def contact_map(place: FloatArray, com: FloatArray) -> FloatArray:
    """(n, 3, 2) from a force at `place` (n, 2) to force and moment about `com` (2,)."""
    arm = place - com
    G = np.zeros((len(place), 3, 2))
    G[:, 0, 0] = G[:, 1, 1] = 1.0
    G[:, 2, 0], G[:, 2, 1] = -arm[:, 1], arm[:, 0]
    return G


def plane_rotations(yaw_rad: FloatArray) -> FloatArray:
    """(n, 2, 2) rotations of the plane."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
