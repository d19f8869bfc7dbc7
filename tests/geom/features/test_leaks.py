"""A ball in a cup gets out through a hole in the wall that is wide enough, and only there."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from geom.features.leaks import leaks
from schemas.arrays import FloatArray

UP = np.array([0.0, 0.0, 1.0])
BALL_M = 0.02


def bin_with_hole(hole_m: float) -> trimesh.Trimesh:
    """An open box 0.2 x 0.2 x 0.2 with walls of 4 mm and a square hole of that edge in one wall."""
    outer, inner = trimesh.creation.box((0.2, 0.2, 0.2)), trimesh.creation.box((0.192, 0.192, 0.2))
    inner.apply_translation((0.0, 0.0, 0.004))
    parts = [outer, inner]
    if hole_m > 0.0:
        hole = trimesh.creation.box((0.1, hole_m, hole_m))
        hole.apply_translation((0.1, 0.0, -0.04))
        parts.append(hole)
    return trimesh.boolean.difference(parts, engine="manifold")


def leaky(mesh: trimesh.Trimesh, X: FloatArray | None = None, scale: float = 1.0) -> bool:
    X = np.eye(4) if X is None else X
    points = np.asarray(mesh.vertices) @ X[:3, :3].T * scale
    inside, mouth = (np.array([0.0, 0.0, z]) @ X[:3, :3].T * scale for z in (-0.05, 0.1))
    return leaks(points, np.asarray(mesh.faces, dtype=np.int32), inside, mouth, X[:3, :3] @ UP, BALL_M * scale)


@pytest.mark.parametrize(("hole_m", "expected"), [(0.0, False), (0.03, False), (0.05, True), (0.1, True)])
def test_a_ball_leaves_through_a_hole_that_is_wider_than_it(hole_m: float, expected: bool) -> None:
    assert leaky(bin_with_hole(hole_m)) is expected


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_neither_pose_nor_size_changes_the_answer(scale: float) -> None:
    X = np.eye(4)
    X[:3, :3] = Rotation.from_euler("xyz", [0.5, -0.3, 0.9]).as_matrix()
    assert not leaky(bin_with_hole(0.0), X, scale)
    assert leaky(bin_with_hole(0.06), X, scale)


def test_a_place_where_no_ball_fits_holds_none() -> None:
    mesh = trimesh.creation.box((0.2, 0.2, 0.2))
    wall = np.array([0.1, 0.0, 0.0])
    assert not leaks(np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int32), wall, UP, UP, BALL_M)
