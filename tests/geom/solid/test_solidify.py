"""The physical surface: closed forms for unions and cavities, shells stay shells, gaps are bridged."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.mesh.manifold_arrays import signed_volume
from geom.mesh.topology import observe
from geom.mesh.winding_number import winding_numbers
from geom.solid.closed_bodies import as_manifold, unite
from geom.solid.solid_distance import solid_distance
from geom.solid.solidify import solidify
from geom.solid.voxel_hull import voxel_hull
from tests.support.sample_surfaces import ball, box, cylinder, inside_out, lidless, mesh_of, together, without


def solid_of(*surfaces):
    return solidify([mesh_of(*s, name=f"m{i}") for i, s in enumerate(surfaces)])


def assert_closed_outward(solid) -> None:
    seen = observe(solid.points, solid.triangles, "")
    assert seen.watertight
    assert seen.inconsistent_edges == 0
    assert not seen.inverted


def test_a_clean_solid_is_taken_as_it_is() -> None:
    solid, figures = solid_of(box((1, 2, 3)))
    assert solid.kind == "closed"
    assert solid.wall_thickness_m is None
    assert figures["volume_m3"] == pytest.approx(6.0)
    assert figures["area_m2"] == pytest.approx(22.0)
    assert solid_distance([mesh_of(*box((1, 2, 3)))], solid).bound < 1e-6


@pytest.mark.parametrize("split", [False, True])
def test_overlap_is_counted_once_within_and_across_meshes(split: bool) -> None:
    a, b = box(), box(at=(0.5, 0.5, 0.5))
    solid, figures = solid_of(a, b) if split else solid_of(together(a, b))
    assert figures["naive_volume_m3"] == pytest.approx(2.0)
    assert figures["volume_m3"] == pytest.approx(2.0 - 0.125)
    assert_closed_outward(solid)


def test_a_same_wound_inner_body_adds_nothing_and_a_reversed_one_is_a_cavity() -> None:
    ball_volume = signed_volume(*ball())
    inner = signed_volume(*ball(0.5))
    assert solid_of(together(ball(), ball(0.5)))[1]["volume_m3"] == pytest.approx(ball_volume)
    solid, figures = solid_of(together(ball(), inside_out(ball(0.5))))
    assert figures["volume_m3"] == pytest.approx(ball_volume - inner)
    assert figures["cavities"] == 1
    assert winding_numbers(np.zeros((1, 3)), solid.points[solid.triangles])[0] == pytest.approx(0.0, abs=1e-9)


def test_a_body_inside_a_cavity_is_kept() -> None:
    nested = together(ball(), inside_out(ball(0.6)), ball(0.3))
    volumes = [signed_volume(*ball(r)) for r in (1.0, 0.6, 0.3)]
    assert solid_of(nested)[1]["volume_m3"] == pytest.approx(volumes[0] - volumes[1] + volumes[2])


def test_broken_surfaces_of_one_solid_give_its_volume() -> None:
    points, triangles = ball(subdivisions=2)
    true = signed_volume(points, triangles)
    turned = triangles.copy()
    turned[::3] = turned[::3, [0, 2, 1]]
    fin = np.vstack([triangles, [[triangles[0, 0], triangles[0, 1], len(points)]]])
    broken = {
        "inside out": (points, triangles[:, [0, 2, 1]]),
        "mixed winding": (points, turned),
        "twice": together((points, triangles), (points, triangles)),
        "double-sided": together((points, triangles), (points, triangles[:, [0, 2, 1]])),
        "fin": (np.vstack([points, points[triangles[0, 0]] * 1.1]), fin),
        "one face missing": (points, triangles[1:]),
        "soup of its faces": (points[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)),
    }
    for name, surface in broken.items():
        solid, figures = solid_of(surface)
        assert figures["volume_m3"] == pytest.approx(true, rel=5e-3), name
        assert_closed_outward(solid)


def test_six_meshes_of_one_side_each_make_a_box() -> None:
    points, triangles = box()
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sides = [(points, triangles[(normals @ n) > 0.5]) for n in np.vstack([np.eye(3), -np.eye(3)])]
    solid, figures = solid_of(*sides)
    assert figures["volume_m3"] == pytest.approx(1.0)
    assert_closed_outward(solid)


@pytest.mark.parametrize(
    "surface", [lidless(box()), lidless(cylinder()), without(ball(), lambda c, _: c[2] > 0)], ids=["box", "cup", "bowl"]
)
def test_containers_stay_shells_with_their_cavity(surface) -> None:
    solid, figures = solid_of(surface)
    assert solid.kind == "shell"
    assert solid.wall_thickness_m == pytest.approx(5e-3)
    assert figures["volume_m3"] == pytest.approx(float(figures["area_m2"]) * 5e-3)
    assert len(solid.triangles) == len(surface[1])


def test_wall_thickness_is_one_percent_of_the_diagonal_within_bounds() -> None:
    for size, wall in ((0.01, 0.5e-3), (0.1, 0.1 * np.sqrt(3) * 0.01), (1.0, 5e-3)):
        points, triangles = lidless(box())
        assert solid_of((points * size, triangles))[0].wall_thickness_m == pytest.approx(wall)


def test_a_card_is_a_shell_also_when_drawn_double_sided() -> None:
    card = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    for surface in (card, together(card, inside_out(card))):
        solid, figures = solid_of(surface)
        assert solid.kind == "shell"
        assert figures["area_m2"] == pytest.approx(1.0)


def test_open_decoration_does_not_spoil_a_solid_and_boards_get_their_hidden_ends() -> None:
    leaf = (np.array([[0.0, 0, 0.5], [0.3, 0, 0.5], [0.3, 0.3, 0.515]]), np.array([[0, 1, 2]]))  # on the top face
    solid, figures = solid_of(box(), leaf)
    assert solid.kind == "closed"
    assert figures["volume_m3"] == pytest.approx(1.0)
    assert 0.0 < float(figures["open_area_share"]) < 0.02
    board = without(box((1, 0.1, 0.03)), lambda _, n: n[0] > 0.99)
    posts = [(board[0] + [0, 0, 0.2 * i], board[1]) for i in range(4)]
    solid, figures = solid_of(together(*posts))
    assert figures["volume_m3"] == pytest.approx(4 * 0.003)
    assert figures["filled_openings"] == 4


def test_a_surface_with_small_gaps_everywhere_gets_a_close_voxel_body() -> None:
    points, triangles = ball(subdivisions=3)
    corners = points[triangles]
    shrunk = corners + 0.03 * (corners.mean(axis=1, keepdims=True) - corners)  # No two faces touch any more.
    visible = mesh_of(shrunk.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    solid, figures = solidify([visible])
    assert (solid.kind, figures["method"]) == ("closed", "voxel")
    assert figures["volume_m3"] == pytest.approx(4 / 3 * np.pi, rel=0.05)
    assert solid_distance([visible], solid).bound < 0.1
    assert_closed_outward(solid)


def test_crossing_strips_without_an_inside_fall_back_to_their_hull() -> None:
    rng = np.random.default_rng(0)
    start, step = rng.random((60, 3)), 0.3 * rng.normal(size=(60, 2, 3))
    corners = np.concatenate([start[:, None], start[:, None] + step], axis=1)
    solid, _ = solid_of((corners.reshape(-1, 3), np.arange(180).reshape(-1, 3)))
    assert solid.kind in {"hull", "shell"}


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**16), offset=st.sampled_from([0.0, 1e3, 1e6]))
def test_volume_and_area_do_not_depend_on_pose_or_place(seed: int, offset: float) -> None:
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    shift = offset * np.random.default_rng(seed).normal(size=3)
    bodies = together(box(), box(at=(0.4, 0.3, 0.2)), inside_out(ball(0.2, 1)))
    _, here = solid_of(bodies)
    _, there = solid_of((bodies[0] @ R.T + shift, bodies[1]))
    for key in ("volume_m3", "area_m2", "naive_volume_m3"):
        assert there[key] == pytest.approx(here[key], rel=1e-6)
    assert (here["method"], here["cavities"]) == (there["method"], there["cavities"])


def test_the_same_meshes_give_the_same_bytes() -> None:
    surfaces = [box(), ball(0.7, 2), lidless(box((0.3, 0.3, 0.3), at=(2, 0, 0)))]
    first, second = (solid_of(*surfaces)[0] for _ in range(2))
    assert first.points.tobytes() == second.points.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()


def test_union_refuses_what_is_no_manifold() -> None:
    assert unite([lidless(box())]) is None
    assert as_manifold(*box()).volume() == pytest.approx(1.0)


def test_voxels_of_a_card_hold_nothing() -> None:
    points, triangles = box((1, 1, 1e-3))
    lid = without((points, triangles), lambda _, n: n[2] < 0.99)
    proxy = voxel_hull(*lid)
    assert proxy is None or signed_volume(proxy[0], proxy[1]) < 0.02


def test_two_containers_side_by_side_stay_shells() -> None:
    assert solid_of(lidless(box()), lidless(box(at=(3, 0, 0))))[0].kind == "shell"


def test_open_parts_beyond_the_bodies_belong_to_the_solid():
    block = box((1.0, 1.0, 1.0))
    card_points = np.array([[0.2, 0.2, 0.5], [0.4, 0.2, 0.5], [0.4, 0.2, 1.5], [0.2, 0.2, 1.5]])
    card = (card_points, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32))
    solid, figures = solid_of(block, card)
    assert figures["method"] == "union_and_walls"
    assert_closed_outward(solid)
    assert solid.points[:, 2].max() == pytest.approx(1.5)
    assert figures["volume_m3"] == pytest.approx(1.0, rel=0.01)


def test_open_decoration_within_the_bodies_is_left_out():
    label = (np.array([[0.1, 0.1, 0.501], [0.3, 0.1, 0.501], [0.3, 0.3, 0.501]]), np.array([[0, 1, 2]], dtype=np.int32))
    figures = solid_of(box((1.0, 1.0, 1.0)), label)[1]
    assert figures["method"] == "union"
    assert figures["volume_m3"] == pytest.approx(1.0)
