"""Copies are aligned whatever their symmetry; mirror images and other shapes are not."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from geom.mesh.aligned_distance import aligned_distance

TURN = Rotation.from_euler("xyz", [40.0, -73.0, 110.0], degrees=True).as_matrix()


def joined(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> trimesh.Trimesh:
    parts = [trimesh.creation.box(size).apply_translation(centre) for size, centre in boxes]
    return merged(*parts)


def merged(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    return trimesh.Trimesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces), process=False)


SHAPES = {
    "three different edges": trimesh.creation.box((0.3, 0.2, 0.1)),
    "a cube, whose axes are undetermined": trimesh.creation.box((0.1, 0.1, 0.1)),
    "a square rod, with one axis": trimesh.creation.box((0.1, 0.1, 0.3)),
    "a square plate, with one axis": trimesh.creation.box((0.3, 0.3, 0.05)),
    "a cylinder": trimesh.creation.cylinder(0.04, 0.1),
    "no symmetry": joined(((3, 1, 1), (0, 0, 0)), ((1, 2, 1), (1, 1.5, 0)), ((1, 1, 1.5), (-1, 0, 1.2))),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_turned_and_scaled_copy_is_aligned(name: str):
    points, triangles = np.array(SHAPES[name].vertices), np.array(SHAPES[name].faces, dtype=np.int32)
    result = aligned_distance(points, triangles, 3.0 * points @ TURN.T - 1.0, triangles[::-1])
    assert result.max_share < 1e-4
    assert result.scale_ratio == pytest.approx(3.0)
    np.testing.assert_allclose(result.R_BA @ result.R_BA.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(result.R_BA) > 0.0


def test_a_mirror_image_without_symmetry_is_another_shape():
    body = SHAPES["no symmetry"]
    points, triangles = np.array(body.vertices), np.array(body.faces, dtype=np.int32)
    mirrored = points * np.array([1.0, -1.0, 1.0])
    assert aligned_distance(points, triangles, mirrored, triangles[:, ::-1]).max_share > 0.05


def test_a_small_part_that_only_one_has_counts_from_either_side():
    plain = trimesh.creation.box((0.3, 0.2, 0.1))
    knob = merged(plain, trimesh.creation.box((0.03, 0.03, 0.04)).apply_translation((0.05, 0.0, 0.07)))
    one, other = ((np.array(m.vertices), np.array(m.faces, dtype=np.int32)) for m in (plain, knob))
    for result in (aligned_distance(*one, *other), aligned_distance(*other, *one)):
        assert result.max_share > 0.05
        assert result.mean_share < 0.02


def test_a_surface_without_area_is_refused():
    triangle = np.zeros((3, 3)), np.array([[0, 1, 2]], dtype=np.int32)
    cube = np.array(SHAPES["a cylinder"].vertices), np.array(SHAPES["a cylinder"].faces, dtype=np.int32)
    with pytest.raises(ValueError, match="no area"):
        aligned_distance(*triangle, *cube)
