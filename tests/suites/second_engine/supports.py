"""What a body stands on in a pose, and by how much two resting orientations differ.

Orientations are compared by the direction that faces down in the asset frame, so yaw is no part of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.acceptance.stable_poses import pose_families, spread_directions
from geom.convex.support_function import centre_heights, diagonal, stability_margin
from geom.mass.principal_axes import principal_axes
from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.physics import RigidBody

_SMALL_FOOT = 0.03  # of the size
_ROLLS_ON = 0.003  # of the height of the mass centre
_SYMMETRIC = 0.01  # of the size
_TURNS_RAD = (0.13, 0.54, 1.34)  # no whole fraction of a turn


def is_curved(body: RigidBody, down_A: FloatArray) -> bool:
    """Whether the support is (a hull of) a curved surface: a foot of less than 3 % of the size, from whose edge the
    body rolls on to the next face within 10 degrees.

    Tipped about a fixed edge, the mass centre's height is `h cos t + lever sin t`; where it is higher by 0.3 %, the
    body stands on something else by then. A narrow foot with nothing beside it, a plank's edge, is not curved.
    """
    centre = np.asarray(body.mass.centre_of_mass_m)
    lever, tipped = stability_margin(body.shapes, centre, down_A)
    side = tipped - (tipped @ down_A) * down_A
    side /= np.linalg.norm(side)
    one, ten = np.radians([1.0, 10.0])
    directions = np.stack(
        [down_A, np.cos(one) * down_A + np.sin(one) * side, np.cos(ten) * down_A + np.sin(ten) * side]
    )
    level, tipped_level, far_level = centre_heights(body.shapes, centre, directions)
    about_edge = level * np.cos(ten) + (tipped_level - level * np.cos(one)) / np.sin(one) * np.sin(ten)
    return bool(lever < _SMALL_FOOT * diagonal(body.shapes) and far_level - about_edge > _ROLLS_ON * level)


def symmetry_axes(body: RigidBody) -> FloatArray:
    """Unit axes (k, 3) through the mass centre about which the body can turn without a visible difference.

    The candidates are the principal axes of inertia; the test is that the height of the mass centre over the ground,
    for 200 directions, changes by less than 1 % of the size. A ball has three.
    """
    axes = matrix_of(principal_axes(body.mass.inertia_kgm2)[1]).T
    return np.array([axis for axis in axes if _is_symmetric(body, axis)]).reshape(-1, 3)


def tilt_between(axes: FloatArray, first_A: FloatArray, second_A: FloatArray) -> float:
    """Angle in radians between two down directions (3,), turns about the symmetry axes (k, 3) left out."""
    direct = _angle(first_A, second_A)
    return min([direct, *(abs(_angle(axis, first_A) - _angle(axis, second_A)) for axis in axes)])


def pose_classes(body: RigidBody, listed_A: Sequence[FloatArray], downs_A: Sequence[FloatArray]) -> list[int | None]:
    """For each down direction the index of the listed stable pose it belongs to (the first, if several), or None.

    By the pipeline's own rule, with all directions at hand as links: a mug on its side is one pose, however it rolled.
    """
    labels = pose_families(body, np.array([*listed_A, *downs_A])).tolist()
    listed = labels[: len(listed_A)]
    return [listed.index(label) if label in listed else None for label in labels[len(listed_A) :]]


def _is_symmetric(body: RigidBody, axis: FloatArray) -> bool:
    centre, directions = np.asarray(body.mass.centre_of_mass_m), spread_directions(200)
    levels = centre_heights(body.shapes, centre, directions)
    turned = [Rotation.from_rotvec(turn * axis).apply(directions) for turn in _TURNS_RAD]
    change = max(np.abs(centre_heights(body.shapes, centre, t) - levels).max() for t in turned)
    return bool(change < _SYMMETRIC * diagonal(body.shapes))


def _angle(first: FloatArray, second: FloatArray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))
