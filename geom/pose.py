"""Poses as row-major 4x4 matrices `X_AB` (pose of B in A, `p_A = X_AB p_B`) and unit quaternions in wxyz order."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray

UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])  # of the world and of asset frames
UP.setflags(write=False)
DOWN.setflags(write=False)


def to_xyzw(quat_wxyz: FloatArray) -> FloatArray:
    """The same quaternions (..., 4) in xyzw order, the order of SciPy and PyBullet."""
    return np.roll(np.asarray(quat_wxyz, dtype=np.float64), -1, axis=-1)


def to_wxyz(quat_xyzw: FloatArray) -> FloatArray:
    """The same quaternions (..., 4) in wxyz order, the order of all our files."""
    return np.roll(np.asarray(quat_xyzw, dtype=np.float64), 1, axis=-1)


def matrix_of(quat_wxyz: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), which need not be normalised.

    Raises ValueError for a zero quaternion.
    """
    quats = to_xyzw(quat_wxyz)
    return Rotation.from_quat(quats.reshape(-1, 4)).as_matrix().reshape(*quats.shape[:-1], 3, 3)


def quat_of(R_AB: FloatArray) -> FloatArray:
    """Unit quaternions wxyz (..., 4) of rotation matrices (..., 3, 3), the one of the two signs with w >= 0."""
    matrices = np.asarray(R_AB, dtype=np.float64)
    quats = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat(canonical=True)
    return to_wxyz(quats).reshape(*matrices.shape[:-2], 4)


def pose(R_AB: FloatArray | None = None, p_AB: FloatArray | tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FloatArray:
    """X_AB (4, 4) from a rotation matrix (3, 3), identity if None, and the position (3,) of B's origin in A."""
    X_AB = np.eye(4)
    if R_AB is not None:
        X_AB[:3, :3] = R_AB
    X_AB[:3, 3] = p_AB
    return X_AB


def rotation_of_rpy(rpy_rad: FloatArray | tuple[float, ...]) -> FloatArray:
    """The rotation matrix (3, 3) of roll, pitch, yaw (3,) as URDF has them: turns about the fixed axes x, y, z."""
    return np.asarray(Rotation.from_euler("xyz", rpy_rad).as_matrix(), dtype=np.float64)


def rpy_of_rotation(R_AB: FloatArray) -> FloatArray:
    """Roll, pitch, yaw (3,) in radians about the fixed axes x, y, z; yaw is 0 where only their sum is determined."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of SciPy, where only the sum is determined
        return np.asarray(Rotation.from_matrix(R_AB).as_euler("xyz"), dtype=np.float64)


def rotation_about(axis: FloatArray | tuple[float, ...], angle_rad: float) -> FloatArray:
    """The rotation matrix (3, 3) of a turn about a unit vector (3,)."""
    return np.asarray(Rotation.from_rotvec(np.asarray(axis) * angle_rad).as_matrix(), dtype=np.float64)


def pose_from_quat(quat_wxyz: FloatArray, p_AB: FloatArray | tuple[float, float, float]) -> FloatArray:
    """X_AB (4, 4) from the orientation of B in A and the position (3,) of B's origin in A."""
    return pose(matrix_of(np.asarray(quat_wxyz)), p_AB)


def inverse(X_AB: FloatArray) -> FloatArray:
    """X_BA (..., 4, 4); exact for rigid poses: `[R^T, -R^T p]`."""
    poses = np.asarray(X_AB, dtype=np.float64)
    R_BA = np.swapaxes(poses[..., :3, :3], -1, -2)
    X_BA = np.broadcast_to(np.eye(4), poses.shape).copy()
    X_BA[..., :3, :3] = R_BA
    X_BA[..., :3, 3] = -np.einsum("...ij,...j->...i", R_BA, poses[..., :3, 3])
    return X_BA


def compose(X_AB: FloatArray, X_BC: FloatArray) -> FloatArray:
    """X_AC (..., 4, 4)."""
    return np.asarray(X_AB) @ np.asarray(X_BC)


def apply(X_AB: FloatArray, p_B: FloatArray) -> FloatArray:
    """Points (n, 3) given in B, expressed in A."""
    return np.asarray(p_B) @ X_AB[:3, :3].T + X_AB[:3, 3]


def angle_between(quat_a_wxyz: FloatArray, quat_b_wxyz: FloatArray) -> FloatArray:
    """Angle (...) in radians, 0..pi, of the rotation that takes orientation a (..., 4) to b (..., 4)."""
    a, b = np.broadcast_arrays(to_xyzw(quat_a_wxyz), to_xyzw(quat_b_wxyz))
    turn = Rotation.from_quat(a.reshape(-1, 4)).inv() * Rotation.from_quat(b.reshape(-1, 4))
    return turn.magnitude().reshape(a.shape[:-1])


def shortest_rotation(u: FloatArray, v: FloatArray) -> FloatArray:
    """The rotation matrix (3, 3) of least angle with `R u = v`, for unit vectors u, v (3,).

    Opposite vectors have no unique one: then a half turn about x, or about y if u is along x, made normal to u.
    """
    u, cosine, axis = np.asarray(u), float(np.dot(u, v)), np.cross(u, v)
    if cosine > 0.0:
        cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
        return np.eye(3) + cross + cross @ cross / (1.0 + cosine)
    # Near opposite vectors the formula above divides by zero: at 1e-6 from them it is off by half a degree.
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        axis = np.array([1.0, 0.0, 0.0]) if abs(u[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    axis = axis - np.dot(axis, u) * u
    return Rotation.from_rotvec(np.arctan2(sine, cosine) * axis / np.linalg.norm(axis)).as_matrix()


def rotation_to_z(direction: FloatArray) -> FloatArray:
    """Rotation (3, 3) that takes `direction` to z; coordinate axes go to coordinate axes, z stays as it is."""
    axis = int(np.abs(direction).argmax())
    x: FloatArray = np.eye(3)[(axis + 1) % 3]
    x = x - (x @ direction) * direction
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction])
