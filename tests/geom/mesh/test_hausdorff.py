"""The distance between surfaces is enclosed: attained by a point, never exceeded by another; closed forms and laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.mesh.hausdorff import one_sided_hausdorff
from geom.mesh.surface_distance import closest_on_surface, sample_surface
from geom.repair.shape_change import changed_faces, shape_change
from geom.solid.solid_distance import solid_distance
from geom.solid.solidify import solidify
from tests.support.sample_surfaces import ball, box, cylinder, inside_out, lidless, mesh_of, together, without


def reach_of(one, other, **options):
    return one_sided_hausdorff(one[0][one[1]], other[0], other[1], 1e-4, **options)


def test_closed_forms() -> None:
    small, large = box(), box((2.0, 2.0, 2.0))
    assert reach_of(large, small).attained == pytest.approx(np.sqrt(3) / 2)  # corner to corner
    assert reach_of(small, large).attained == pytest.approx(0.5)  # face to face
    lid = without(cylinder(), lambda _, normal: normal[2] < 0.99)
    apothem = 0.5 * np.cos(np.pi / 24)
    found = reach_of(lid, lidless(cylinder()))
    assert found.attained == pytest.approx(apothem, abs=1e-4)
    assert found.at == pytest.approx([0, 0, 0.5], abs=1e-3)


def test_what_lies_inside_a_solid_is_at_no_distance() -> None:
    inner, crossing = box((0.5, 0.5, 0.5)), box((0.5, 0.5, 2.0))
    assert reach_of(inner, box(), solid=True).bound == 0.0
    assert reach_of(crossing, box(), solid=True).attained == pytest.approx(0.5)
    assert reach_of(inner, box()).attained == pytest.approx(0.25)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**16))
def test_no_sample_is_further_than_the_bound_and_the_gap_is_within_tolerance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = box(rng.uniform(0.2, 1.5, 3)), ball(rng.uniform(0.3, 1.0), 2, at=rng.uniform(-0.5, 0.5, 3))
    found = reach_of(one, other)
    samples, _ = sample_surface(*one, 500, seed)
    away = np.linalg.norm(closest_on_surface(samples, *other)[0] - samples, axis=1)
    assert away.max() <= found.bound + 1e-6
    assert found.attained <= found.bound <= found.attained + 1e-4 + 1e-9
    nearest, _ = closest_on_surface(found.at[None], *other)
    assert np.linalg.norm(nearest[0] - found.at) == pytest.approx(found.attained, abs=1e-6)


def test_a_spent_budget_leaves_a_wider_gap_and_says_so() -> None:
    found = reach_of(box((4, 4, 4)), ball(), budget=50)
    assert found.attained <= 2 * np.sqrt(3) - 1 + 1e-2
    assert found.bound > found.attained + 1e-3


def test_an_edit_costs_only_the_faces_it_changed() -> None:
    points, triangles = ball(subdivisions=3)
    gone, new = changed_faces((points, triangles), (points, triangles[7:]))
    assert np.flatnonzero(gone).tolist() == list(range(7))
    assert not new.any()
    turned = changed_faces((points, triangles), (points[::-1], len(points) - 1 - triangles[::-1, [0, 2, 1]]))
    assert not turned[0].any()
    assert not turned[1].any()


def test_mirrored_corners_are_told_apart() -> None:
    corners = np.array([[s * 1.0, t * 2.0, u * 3.0] for s in (-1, 1) for t in (-1, 1) for u in (-1, 1)])
    faces = np.array([[i, j, k] for i in range(8) for j in range(i) for k in range(j)])
    for i in range(0, len(faces), 5):
        gone, _ = changed_faces((corners, faces), (corners, np.delete(faces, i, axis=0)))
        assert np.flatnonzero(gone).tolist() == [i]


def test_the_way_there_and_back() -> None:
    whole, part = box(), lidless(box())
    there, back = shape_change(whole, part), shape_change(part, whole)
    assert there.removed.attained == back.added.attained == pytest.approx(0.5, abs=1e-3)
    assert there.added.attained == back.removed.attained == 0.0
    assert shape_change(whole, whole).bound == 0.0
    assert shape_change(whole, inside_out(whole)).bound == 0.0


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**16), scale=st.sampled_from([1e-3, 1.0, 1e3]))
def test_place_pose_and_scale_do_not_matter(seed: int, scale: float) -> None:
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    shift = np.random.default_rng(seed).normal(size=3)

    def posed(surface):
        return scale * (surface[0] @ R.T + shift), surface[1]

    here = shape_change(ball(subdivisions=2), (ball(subdivisions=2)[0] * 1.1, ball(subdivisions=2)[1]))
    there = shape_change(posed(ball(subdivisions=2)), posed((ball(subdivisions=2)[0] * 1.1, ball(subdivisions=2)[1])))
    assert there.hausdorff == pytest.approx(scale * here.hausdorff, rel=1e-5)


def test_the_solid_is_measured_against_what_is_seen() -> None:
    clean = [mesh_of(*box())]
    assert solid_distance(clean, solidify(clean)[0]).bound == 0.0
    overlapping = [mesh_of(*together(box(), box(at=(0.5, 0.2, 0.1))))]
    assert solid_distance(overlapping, solidify(overlapping)[0]).attained < 1e-6
    flag = (np.array([[0.5, 0, 0.0], [0.515, 0, 0.0], [0.515, 0, 0.03]]), np.array([[0, 1, 2]]))  # under 1 %: trim
    flagged = [mesh_of(*box()), mesh_of(*flag)]
    found = solid_distance(flagged, solidify(flagged)[0])
    assert found.missing.attained == pytest.approx(0.015, abs=1e-3)
    assert found.added.bound == 0.0
