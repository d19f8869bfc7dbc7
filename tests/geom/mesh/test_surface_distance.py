"""Laws of sampled surface distance: closed forms, symmetry of the two ways, invariance, determinism."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from geom.mesh.surface_distance import closest_on_surface, sample_surface, triangle_areas, two_way_distance


def _box(size=(1.0, 1.0, 1.0)) -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.box(size)
    return np.array(mesh.vertices), np.array(mesh.faces)


def test_a_surface_is_at_no_distance_from_itself() -> None:
    points, triangles = _box()
    distance = two_way_distance(points, triangles, points, triangles, 500, 0)
    assert distance.hausdorff < 1e-6


def test_larger_box_is_half_a_unit_away_face_to_face_and_its_corners_further() -> None:
    inner, triangles = _box()
    outer, _ = _box((2.0, 2.0, 2.0))
    distance = two_way_distance(outer, triangles, inner, triangles, 2000, 0)
    assert distance.a_to_b_max == pytest.approx(np.sqrt(3) / 2, rel=1e-5)  # corner to corner
    assert distance.b_to_a_max == pytest.approx(0.5, rel=1e-5)  # a face looks straight out
    assert distance.b_to_a_p95 == pytest.approx(0.5, rel=1e-5)


def test_swapping_the_arguments_swaps_the_figures() -> None:
    inner, triangles = _box()
    outer, _ = _box((1.2, 1.1, 1.0))
    there = two_way_distance(inner, triangles, outer, triangles, 300, 3)
    back = two_way_distance(outer, triangles, inner, triangles, 300, 3)
    assert (there.a_to_b_p95, there.a_to_b_max) == (back.b_to_a_p95, back.b_to_a_max)


@settings(max_examples=15, deadline=None)
@given(offset=st.sampled_from([0.0, 1e3, 1e6]), scale=st.sampled_from([1e-3, 1.0, 1e3]))
def test_place_does_not_matter_and_lengths_scale(offset: float, scale: float) -> None:
    inner, triangles = _box()
    outer, _ = _box((1.2, 1.1, 1.3))
    base = two_way_distance(inner, triangles, outer, triangles, 200, 1)
    moved = two_way_distance(inner * scale + offset, triangles, outer * scale + offset, triangles, 200, 1)
    assert moved.hausdorff == pytest.approx(base.hausdorff * scale, rel=1e-5, abs=1e-9 * max(offset, 1.0))


def test_the_same_arguments_give_the_same_figures() -> None:
    inner, triangles = _box()
    outer, _ = _box((1.2, 1.1, 1.3))
    runs = {two_way_distance(inner, triangles, outer, triangles, 500, 7) for _ in range(3)}
    assert len(runs) == 1


def test_samples_lie_on_their_triangles_in_proportion_to_area() -> None:
    points, triangles = _box((1.0, 2.0, 3.0))
    samples, index = sample_surface(points, triangles, 4000, 0)
    nearest, _ = closest_on_surface(samples, points, triangles)
    assert np.allclose(samples, nearest, atol=1e-6)
    share = triangle_areas(points[triangles]) / triangle_areas(points[triangles]).sum()
    assert np.allclose(np.bincount(index, minlength=12) / 4000, share, atol=1e-3)


def test_zero_area_triangles_are_neither_sampled_nor_hit() -> None:
    points, triangles = _box()
    with_line = np.concatenate([[[0, 0, 1]], triangles])
    _, index = sample_surface(points, with_line, 500, 0)
    assert (index > 0).all()
    nearest, hit = closest_on_surface(points * 2, points, with_line)
    assert np.isfinite(nearest).all()
    assert (hit > 0).all()


def test_a_surface_without_area_is_refused() -> None:
    points, triangles = _box()
    flat = np.array([[0, 1, 1]])
    with pytest.raises(ValueError, match="no area"):
        two_way_distance(points, flat, points, triangles, 10, 0)
    with pytest.raises(ValueError, match="no area"):
        closest_on_surface(points, points, flat)
