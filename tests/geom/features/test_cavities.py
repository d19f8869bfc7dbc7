"""Containers are found and kept open; blocks, plates and chairs are no containers; pipes are through-holes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

from geom.convex.hull import hull_shape
from geom.features.cavities import find_cavities, keeps_cavity
from geom.pose import pose
from schemas.physics import CollisionShape, Solid


def solid_of(body: Manifold) -> Solid:
    mesh = body.to_mesh64()
    return Solid(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32), "closed")


def bin_solid(size=(0.4, 0.3, 0.2), wall=0.01) -> Solid:
    outer = Manifold.cube(size)
    inner = Manifold.cube((size[0] - 2 * wall, size[1] - 2 * wall, size[2])).translate((wall, wall, wall))
    return solid_of(outer - inner)


def walls(size=(0.4, 0.3, 0.2), wall=0.01) -> list[CollisionShape]:
    x, y, z = size
    boxes = [
        ((x, y, wall), (x / 2, y / 2, wall / 2)),
        ((wall, y, z), (wall / 2, y / 2, z / 2)),
        ((wall, y, z), (x - wall / 2, y / 2, z / 2)),
        ((x, wall, z), (x / 2, wall / 2, z / 2)),
        ((x, wall, z), (x / 2, y - wall / 2, z / 2)),
    ]
    return [CollisionShape("box", s, pose(None, c)) for s, c in boxes]


def test_a_bin_opens_upward_with_its_true_size():
    (cavity,) = find_cavities(bin_solid())
    np.testing.assert_allclose(cavity.direction, [0, 0, 1])
    assert cavity.diameter_m == pytest.approx(0.28, abs=2.5 * 0.4 / 64)
    assert cavity.depth_m == pytest.approx(0.19, abs=1e-6)
    assert cavity.volume_m3 == pytest.approx(0.38 * 0.28 * 0.19, rel=0.1)
    assert cavity.opening_m[2] == pytest.approx(0.2)
    assert not cavity.through


@pytest.mark.parametrize("turn", [(0, 90, 0), (0, -90, 0), (90, 0, 0), (180, 0, 0)])
def test_the_opening_direction_turns_with_the_bin(turn):
    upright = bin_solid()
    R = trimesh.transformations.euler_matrix(*np.radians(turn))[:3, :3].round(12)
    (cavity,) = find_cavities(Solid(upright.points @ R.T, upright.triangles, "closed"))
    np.testing.assert_allclose(cavity.direction, R @ [0, 0, 1], atol=1e-9)
    assert cavity.depth_m == pytest.approx(0.19, abs=1e-6)


def test_a_sheet_without_thickness_holds_water_too():
    box = trimesh.creation.box((0.3, 0.2, 0.15))
    lidless = np.abs(box.triangles_center[:, 2] - 0.075) > 1e-6
    sheet = Solid(np.array(box.vertices), np.array(box.faces)[lidless].astype(np.int32), "shell", 0.002)
    (cavity,) = find_cavities(sheet)
    assert cavity.depth_m == pytest.approx(0.15, rel=0.02)
    assert cavity.diameter_m == pytest.approx(0.2, rel=0.1)


def test_a_hemisphere_bowl_lets_the_ball_touch_the_ground():
    bowl = Manifold.sphere(0.1, 64) - Manifold.sphere(0.095, 64)
    (cavity,) = find_cavities(solid_of(bowl.trim_by_plane((0, 0, -1), 0.0)))
    assert cavity.depth_m == pytest.approx(0.095, rel=0.02)
    assert cavity.reach_m == pytest.approx(0.095, rel=0.1)


def test_a_pipe_is_a_through_hole_listed_once():
    pipe = solid_of(Manifold.cylinder(0.2, 0.05, 0.05, 48) - Manifold.cylinder(0.2, 0.04, 0.04, 48))
    (cavity,) = find_cavities(pipe)
    assert cavity.through
    assert cavity.depth_m == pytest.approx(0.2)


def test_a_window_in_a_wall_is_a_through_hole_and_a_drilled_hole_is_not():
    wall = Manifold.cube((2.0, 0.1, 2.0))
    window = solid_of(wall - Manifold.cube((0.8, 0.4, 0.8)).translate((0.6, -0.1, 0.6)))
    (cavity,) = find_cavities(window)
    assert cavity.through
    assert cavity.diameter_m == pytest.approx(0.8, abs=0.1)
    hull = hull_shape(window.points)
    assert hull is not None
    assert not keeps_cavity([hull], cavity)
    assert find_cavities(solid_of(wall - Manifold.cube((0.1, 0.4, 0.1)).translate((0.9, -0.1, 0.9)))) == ()


# Made when asked for: a Manifold that lives as long as the module makes nanobind report a leak at exit.
def chair() -> Manifold:
    seat, back = Manifold.cube((0.4, 0.4, 0.04)).translate((0, 0, 0.4)), Manifold.cube((0.4, 0.04, 0.9))
    leg = Manifold.cube((0.04, 0.04, 0.4))
    return seat + back + leg.translate((0, 0.36, 0)) + leg.translate((0.36, 0.36, 0))


def dented_plate() -> Manifold:
    dent = Manifold.cylinder(0.01, 0.09, 0.09, 48).translate((0, 0, 0.007))
    return Manifold.cylinder(0.01, 0.1, 0.1, 48) - dent


@pytest.mark.parametrize(
    "body",
    [lambda: Manifold.cube((1, 1, 1)), lambda: Manifold.sphere(1.0, 48), chair, dented_plate],
    ids=["cube", "ball", "chair", "plate"],
)
def test_what_holds_no_water_is_no_container(body):
    assert find_cavities(solid_of(body())) == ()


def test_walls_keep_the_cavity_and_a_hull_fills_it():
    solid = bin_solid()
    (cavity,) = find_cavities(solid)
    hull = hull_shape(solid.points)
    assert hull is not None
    assert keeps_cavity(walls(), cavity)
    assert not keeps_cavity([hull], cavity)
    plug = CollisionShape("box", (0.1, 0.1, 0.02), pose(None, (0.2, 0.15, 0.15)))
    assert not keeps_cavity([*walls(), plug], cavity)
    tiny_plug = CollisionShape("sphere", (0.002,), pose(None, (0.2, 0.15, 0.12)))
    assert not keeps_cavity([*walls(), tiny_plug], cavity)


def test_a_hull_solid_has_no_openings():
    solid = bin_solid()
    assert find_cavities(Solid(solid.points, solid.triangles, "hull")) == ()
