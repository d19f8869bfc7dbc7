"""Corner normals: flat where sharp, smooth where round."""

from __future__ import annotations

import numpy as np
import trimesh

from geom.mesh.corner_normals import corner_normals, face_normals


def test_cube_stays_sharp() -> None:
    box = trimesh.creation.box()
    normals = corner_normals(np.array(box.vertices), np.array(box.faces))
    np.testing.assert_allclose(normals, np.repeat(box.face_normals[:, None], 3, axis=1), atol=1e-6)


def test_sphere_is_smooth_whatever_the_seams_and_the_size() -> None:
    ball = trimesh.creation.icosphere(3, 1e-4)
    points, triangles = np.array(ball.vertices), np.array(ball.faces)
    expected = points[triangles] / 1e-4
    np.testing.assert_allclose(corner_normals(points, triangles), expected, atol=0.02)
    soup = points[triangles].reshape(-1, 3)
    split = corner_normals(soup, np.arange(len(soup)).reshape(-1, 3))
    np.testing.assert_allclose(split, corner_normals(points, triangles), atol=1e-6)


def test_cylinder_has_round_side_and_sharp_rims() -> None:
    can = trimesh.creation.cylinder(1.0, 2.0, sections=12)
    normals = corner_normals(np.array(can.vertices), np.array(can.faces))
    upright = np.abs(can.face_normals[:, 2]) > 0.5
    np.testing.assert_allclose(np.abs(normals[upright][..., 2]), 1.0, atol=1e-6)
    np.testing.assert_allclose(normals[~upright][..., 2], 0.0, atol=1e-6)
    radial = can.vertices[can.faces[~upright]][..., :2]
    assert np.einsum("fci,fci->fc", normals[~upright][..., :2], radial).min() > 0.98


def test_faces_without_area_and_empty_meshes() -> None:
    points = np.zeros((3, 3))
    assert corner_normals(points, np.array([[0, 1, 2]])).tolist() == [[[0, 0, 1]] * 3]
    assert face_normals(points, np.array([[0, 1, 2]])).tolist() == [[0, 0, 1]]
    assert corner_normals(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)).shape == (0, 3, 3)
