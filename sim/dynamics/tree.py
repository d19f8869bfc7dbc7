"""Rigid-body dynamics of a tree of one-degree joints on a fixed base, vectorised over worlds.

Recursive Newton-Euler and the mass matrix from it (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5 and 6).
Every array has a leading axis w of independent worlds, so that one call serves every window of every trial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray


@dataclass(frozen=True)
class Link:
    """A joint and the body it carries.

    parent        index of the parent link, -1 for the base.
    prismatic     slides along `axis_J` instead of turning about it.
    axis_J        (3,) unit vector in the joint frame, which is also the body's frame.
    X_PJ          (4, 4) joint frame in the parent's frame at q = 0.
    mass_kg, com_J (3,), inertia_J (3, 3) about the mass centre, axes of J.
    armature      inertia of the drive behind the joint (kg m2, or kg), which acts on this joint alone.
    gravity_factor  weight of the link over mass times gravity; 1 unless its load is in doubt.
    """

    name: str
    parent: int
    prismatic: bool
    axis_J: FloatArray
    X_PJ: FloatArray
    mass_kg: float
    com_J: FloatArray
    inertia_J: FloatArray
    armature: float = 0.0
    gravity_factor: float = 1.0


Tree = tuple[Link, ...]


def inverse_dynamics(
    tree: Tree, q: FloatArray, qd: FloatArray, qdd: FloatArray, gravity_W: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint efforts (w, j) that cause `qdd` in state `q`, `qd` (w, j), and the load of each bearing (w, j).

    The load is the magnitude of the force (N) through a revolute joint, of the force across a prismatic one.
    """
    worlds, joints = q.shape
    R, p = placements(tree, q)
    w, a_w, a = (np.zeros((joints, worlds, 3)) for _ in range(3))
    F, N = np.zeros((joints, worlds, 3)), np.zeros((joints, worlds, 3))
    for i, link in enumerate(tree):
        # Everything in the link's own frame; the base accelerates upwards against gravity.
        wp, dwp, ap = (
            (w[link.parent], a_w[link.parent], a[link.parent])
            if link.parent >= 0
            else (np.zeros((worlds, 3)), np.zeros((worlds, 3)), np.broadcast_to(-gravity_W, (worlds, 3)))
        )
        r = p[i]
        a_joint = ap + _cross(dwp, r) + _cross(wp, _cross(wp, r))
        w0, dw0, a0 = _in_joint_frame(R[i], wp), _in_joint_frame(R[i], dwp), _in_joint_frame(R[i], a_joint)
        rate, change = qd[:, i, None] * link.axis_J, qdd[:, i, None] * link.axis_J
        if link.prismatic:
            w[i], a_w[i] = w0, dw0
            a[i] = a0 + change + 2.0 * _cross(w0, rate)
        else:
            w[i] = w0 + rate
            a_w[i] = dw0 + change + _cross(w0, rate)
            a[i] = a0
        a_com = a[i] + _cross(a_w[i], link.com_J) + _cross(w[i], _cross(w[i], link.com_J))
        F[i] = link.mass_kg * a_com
        if link.gravity_factor != 1.0:
            F[i] -= (link.gravity_factor - 1.0) * link.mass_kg * _in_link(tree, R, i, gravity_W)
        spin = w[i] @ link.inertia_J
        N[i] = a_w[i] @ link.inertia_J + _cross(w[i], spin) + _cross(link.com_J, F[i])
    effort, load = np.zeros((worlds, joints)), np.zeros((worlds, joints))
    for i in range(joints - 1, -1, -1):
        link = tree[i]
        across = F[i] - (F[i] @ link.axis_J)[:, None] * link.axis_J if link.prismatic else F[i]
        load[:, i] = np.linalg.norm(across, axis=1)
        effort[:, i] = (F[i] if link.prismatic else N[i]) @ link.axis_J + link.armature * qdd[:, i]
        if link.parent >= 0:
            force = np.einsum("wab,wb->wa", R[i], F[i])
            F[link.parent] += force
            N[link.parent] += np.einsum("wab,wb->wa", R[i], N[i]) + _cross(p[i], force)
    return effort, load


def mass_matrix(tree: Tree, q: FloatArray) -> FloatArray:
    """(w, j, j), symmetric positive definite; kg m2, kg m or kg."""
    zero = np.zeros_like(q)
    columns = []
    for i in range(q.shape[1]):
        unit = zero.copy()
        unit[:, i] = 1.0
        columns.append(inverse_dynamics(tree, q, zero, unit, np.zeros(3))[0])
    M = np.stack(columns, axis=2)
    return 0.5 * (M + M.transpose(0, 2, 1))


def placements(tree: Tree, q: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
    """Per link: rotation R_PJ (w, 3, 3) and position of the joint frame in the parent's frame (w, 3)."""
    rotations, positions = [], []
    for i, link in enumerate(tree):
        R0, p0 = link.X_PJ[:3, :3], link.X_PJ[:3, 3]
        if link.prismatic:
            rotations.append(np.broadcast_to(R0, (len(q), 3, 3)))
            positions.append(p0 + (q[:, i, None] * link.axis_J) @ R0.T)
        else:
            rotations.append(R0 @ _axis_rotation(link.axis_J, q[:, i]))
            positions.append(np.broadcast_to(p0, (len(q), 3)))
    return rotations, positions


def _axis_rotation(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """(w, 3, 3) rotations about a unit vector (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle)[:, None, None] * K + (1.0 - np.cos(angle))[:, None, None] * (K @ K)


def _in_link(tree: Tree, R: list[FloatArray], i: int, v_W: FloatArray) -> FloatArray:
    """A world vector (3,) in the frame of link i (w, 3)."""
    chain = []
    while i >= 0:
        chain.append(i)
        i = tree[i].parent
    v = np.broadcast_to(v_W, (len(R[0]), 3))
    for k in reversed(chain):
        v = _in_joint_frame(R[k], v)
    return v


def _in_joint_frame(R_PJ: FloatArray, v_P: FloatArray) -> FloatArray:
    """Vectors (w, 3) of the parent's frame in the joint's frame."""
    return np.einsum("wba,wb->wa", R_PJ, v_P)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b (w, 3) of vectors (w, 3), of which one may be (3,): the sums of `np.cross` at a third of its cost."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    product = np.empty((len(a if a.ndim > 1 else b), 3))
    product[:, 0] = ay * bz - az * by
    product[:, 1] = az * bx - ax * bz
    product[:, 2] = ax * by - ay * bx
    return product
