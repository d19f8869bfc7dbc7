"""Principal moments and axes of an inertia tensor (3, 3), and the tensor in a rotated frame."""

from __future__ import annotations

import numpy as np
from scipy.linalg import polar

from geom.pose import matrix_of, quat_of
from schemas.arrays import FloatArray


def principal_axes(inertia_kgm2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal moments (3,) ascending and `quat_wxyz` (4,) of the principal frame, w >= 0.

    With R the rotation matrix of the quaternion, `inertia = R diag(moments) R^T`. A tensor that is already diagonal
    keeps its axes (identity, moments in axis order), so that symmetric bodies do not get arbitrary frames.
    The tensor (3, 3) must be symmetric; its antisymmetric rounding residue is ignored.
    """
    symmetric = 0.5 * (inertia_kgm2 + inertia_kgm2.T)
    off_diagonal = np.abs(symmetric - np.diag(np.diag(symmetric))).max()
    if off_diagonal <= 1e-12 * np.abs(np.diag(symmetric)).max():
        return np.diag(symmetric).copy(), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(symmetric)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]  # A reflection has no quaternion; either sign of an axis is principal.
    return moments, quat_of(axes)


def inertia_from_principal(moments: FloatArray, quat_wxyz: FloatArray) -> FloatArray:
    """(3, 3) tensor `R diag(moments) R^T`, the inverse of `principal_axes`."""
    axes = matrix_of(quat_wxyz)
    return axes @ np.diag(moments) @ axes.T


def rotated_tensor(inertia: FloatArray, linear: FloatArray) -> FloatArray:
    """(3, 3) tensor `R I R^T` seen from an outer frame, R being the orthogonal part of `linear` (3, 3).

    `linear` maps directions of the inner frame to the outer one and may scale or mirror; scale does not change a
    tensor given in kg m^2. Source: polar decomposition `linear = R P` (Higham 1986). A singular `linear` leaves R
    undetermined along the lost direction.
    """
    R, _ = polar(linear)
    turned = R @ inertia @ R.T
    return 0.5 * (turned + turned.T)
