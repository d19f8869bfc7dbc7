"""What is counted on known surfaces, and that counts, area and volume do not depend on place or pose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.mesh.topology import is_all_degenerate, is_triangle_soup, observe
from geom.mesh.weld import weld, weld_points
from tests.support.sample_surfaces import ball, box, cylinder, inside_out, lidless, mesh_of, together

COUNTS = [
    *("triangles", "points", "components", "degenerate_faces", "duplicate_faces", "boundary_edges"),
    *("non_manifold_edges", "non_manifold_vertices", "inconsistent_edges", "inverted", "watertight"),
    *("duplicate_shells", "inner_shells", "fragments"),
]

HOLLOW = together(ball(1.0), inside_out(ball(0.5)))
BOW_TIE = together(box(at=(0.5, 0.5, 0.5)), box(at=(-0.5, -0.5, -0.5)))
FIN = (np.vstack([box()[0], [[0.0, 0.0, 2.0]]]), np.vstack([box()[1], [[0, 1, 8]]]).astype(np.int32))
SAMPLES = {
    "box": box(),
    "cylinder": cylinder(),
    "lidless": lidless(box()),
    "hollow": HOLLOW,
    "bow tie": BOW_TIE,
    "fin": FIN,
    "inverted": inside_out(ball(subdivisions=1)),
    "twice": together(box(), box()),
}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("box", {"watertight": True, "components": 1, "volume": 1.0, "area": 6.0, "points": 8}),
        ("lidless", {"watertight": False, "boundary_edges": 4, "volume": None, "area": 5.0}),
        ("hollow", {"watertight": True, "components": 2, "inner_shells": 1, "inverted": False}),
        ("bow tie", {"watertight": True, "components": 2, "non_manifold_vertices": 1, "volume": 2.0, "points": 15}),
        ("fin", {"watertight": False, "non_manifold_edges": 1, "boundary_edges": 2}),
        ("inverted", {"watertight": True, "inverted": True, "inconsistent_edges": 0}),
        ("twice", {"duplicate_shells": 1, "duplicate_faces": 12, "volume": 2.0}),
    ],
)
def test_known_surfaces(name: str, expected: dict) -> None:
    points, triangles = SAMPLES[name]
    seen = observe(points, triangles, name)
    for key, value in expected.items():
        assert getattr(seen, key) == pytest.approx(value), key


@settings(max_examples=25, deadline=None)
@given(
    name=st.sampled_from(sorted(SAMPLES)),
    seed=st.integers(0, 2**16),
    offset=st.sampled_from([0.0, 1.0, 1e3, 1e6]),
)
def test_counts_area_and_volume_do_not_depend_on_pose_or_place(name: str, seed: int, offset: float) -> None:
    points, triangles = SAMPLES[name]
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    direction = np.random.default_rng(seed).normal(size=3)
    here = observe(points, triangles, name)
    there = observe(points @ R.T + offset * direction, triangles, name)
    assert {k: getattr(there, k) for k in COUNTS} == {k: getattr(here, k) for k in COUNTS}
    assert there.area == pytest.approx(here.area, rel=1e-6)
    assert (there.volume is None) == (here.volume is None)
    if here.volume is not None:
        assert there.volume == pytest.approx(here.volume, rel=1e-6)


@given(seed=st.integers(0, 2**16))
@settings(max_examples=20, deadline=None)
def test_counts_do_not_depend_on_the_order_of_faces_and_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for points, triangles in (HOLLOW, FIN, BOW_TIE):
        shuffled = triangles[rng.permutation(len(triangles))]
        shuffled = np.stack([np.roll(face, rng.integers(3)) for face in shuffled])
        one, other = observe(points, triangles, ""), observe(points, shuffled, "")
        assert {k: getattr(one, k) for k in COUNTS} == {k: getattr(other, k) for k in COUNTS}


def test_degenerate_and_duplicate_faces_are_counted() -> None:
    points, triangles = box()
    middle = (points[triangles[0, 0]] + points[triangles[0, 1]]) / 2
    extra = [[0, 0, 1], [triangles[0, 0], triangles[0, 1], 8], triangles[3], triangles[4][[0, 2, 1]]]
    seen = observe(np.vstack([points, middle]), np.vstack([triangles, extra]), "")
    assert (seen.degenerate_faces, seen.duplicate_faces) == (2, 2)


def test_one_turned_face_makes_three_inconsistent_edges() -> None:
    points, triangles = ball(subdivisions=1)
    triangles = triangles.copy()
    triangles[7] = triangles[7, [0, 2, 1]]
    seen = observe(points, triangles, "")
    assert seen.inconsistent_edges == 3
    assert seen.watertight


def test_an_inverted_hollow_ball_is_inverted_once_and_a_cavity_is_not() -> None:
    assert not observe(*HOLLOW, "").inverted
    assert observe(*inside_out(HOLLOW), "").inverted


def test_a_slightly_moved_copy_is_still_a_duplicate_shell_and_a_back_side_is_not() -> None:
    assert observe(*together(box(), box(at=(2e-6, 0, 0))), "").duplicate_shells == 1
    assert observe(*together(box(), inside_out(box())), "").duplicate_shells == 0
    assert observe(*together(box(), box(at=(2, 0, 0))), "").duplicate_shells == 0


def test_fragments_and_thin_parts() -> None:
    crumb = ball(0.004, 0, at=(1.2, 0, 0))
    sheet = box((1.0, 1.0, 0.001), at=(3, 0, 0))
    assert observe(*together(ball(), crumb), "").fragments == 1
    assert observe(*together(ball(), sheet), "").thin_parts == 1
    assert observe(*crumb, "").fragments == 0


def test_triangle_soup_has_no_shared_edges() -> None:
    corners = np.random.default_rng(0).random((100, 3, 3)).reshape(-1, 3)
    soup = observe(corners, np.arange(300).reshape(-1, 3), "")
    assert is_triangle_soup(soup)
    assert not is_triangle_soup(observe(corners[:60], np.arange(60).reshape(-1, 3), ""))
    assert not is_triangle_soup(observe(*ball(), ""))


def test_all_degenerate() -> None:
    line = observe(np.linspace(0, 1, 9)[:, None] * [1.0, 2.0, 3.0], np.arange(9).reshape(-1, 3), "")
    assert is_all_degenerate(line)
    assert not is_all_degenerate(observe(*box(), ""))
    assert not is_all_degenerate(observe(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32), ""))


def test_welding_keeps_faces_and_corners_and_joins_seams() -> None:
    points, triangles = ball(subdivisions=1)
    soup = mesh_of(points[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    welded = weld(soup)
    assert len(welded.points) == len(points)
    assert np.array_equal(welded.points[welded.triangles], soup.points[soup.triangles])
    assert welded.uvs is soup.uvs
    assert observe(welded.points, welded.triangles, "").watertight


def test_welding_uses_the_tolerance_and_drops_loose_points() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1e-9, 0, 0], [1, 1, 0], [9, 9, 9]])
    triangles = np.array([[0, 1, 2], [3, 4, 1]])
    assert len(weld_points(points, triangles)[0]) == 4
    assert len(weld_points(points, triangles, 0.0)[0]) == 5
    assert weld_points(points, triangles, 2.0)[0].shape == (1, 3)
