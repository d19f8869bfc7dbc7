"""Fidelity figures against shapes whose errors are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from geom.decomposition.fidelity import SLIT_GROWTH_SHARE, measure_fidelity, outer_surface, union_surface, union_volume
from geom.features.cavities import find_cavities
from geom.mesh import primitives
from geom.mesh.manifold_arrays import manifold_arrays
from geom.pose import pose
from schemas.physics import CollisionShape, Solid

SLACK = 2.0 * SLIT_GROWTH_SHARE


def box(size, centre=(0.0, 0.0, 0.0)) -> CollisionShape:
    return CollisionShape("box", size, pose(None, centre))


def cube_solid(edge: float = 1.0) -> Solid:
    points, triangles, _ = primitives.cube(edge)
    return Solid(points, triangles.astype(np.int32), "closed")


def test_a_shape_stands_perfectly_for_itself():
    f = measure_fidelity("box", [box((1, 1, 1))], cube_solid(), [])
    assert f.volume_ratio == pytest.approx(1.0)
    assert max(f.outside_p95, f.outside_max, f.missing_p95, f.missing_max) <= SLACK
    assert f.cavity_kept is None
    assert f.vertices == 0


def test_a_box_grown_by_ten_percent_is_five_percent_of_an_edge_away():
    f = measure_fidelity("box", [box((1.1, 1.1, 1.1))], cube_solid(), [])
    assert f.volume_ratio == pytest.approx(1.331)
    assert f.missing_max == 0.0
    assert f.outside_p95 >= 0.05 / np.sqrt(3)
    assert f.outside_max == pytest.approx(0.05, abs=SLACK)  # the corner: 0.05 √3 over √3


def test_a_box_shrunk_by_ten_percent_misses_five_percent_of_an_edge():
    f = measure_fidelity("box", [box((0.9, 0.9, 0.9))], cube_solid(), [])
    assert f.missing_p95 >= 0.05 / np.sqrt(3) - SLACK
    assert f.missing_max == pytest.approx(0.05, abs=SLACK)
    assert f.outside_p95 == pytest.approx(0.05 / np.sqrt(3), abs=SLACK)


def test_scale_and_place_change_nothing():
    here = measure_fidelity("box", [box((1.1, 1.0, 1.0))], cube_solid(), [])
    far = cube_solid(1e-3)
    there = measure_fidelity(
        "box", [box((1.1e-3, 1e-3, 1e-3), (5, 5, 5))], Solid(far.points + 5.0, far.triangles, "closed"), []
    )
    assert there.volume_ratio == pytest.approx(here.volume_ratio)
    assert there.outside_p95 == pytest.approx(here.outside_p95, abs=1e-5)


def test_touching_halves_are_one_box_without_inner_walls():
    halves = [box((0.5, 1, 1), (-0.25, 0, 0)), box((0.5, 1, 1), (0.25 + 1e-12, 0, 0))]
    f = measure_fidelity("hulls", halves, cube_solid(), [])
    assert f.outside_max <= SLACK
    assert f.volume_ratio == pytest.approx(1.0)


def test_overlap_counts_once():
    assert union_volume([box((1, 1, 1)), box((1, 1, 1), (0.5, 0, 0))]) == pytest.approx(1.5)
    points, triangles = union_surface([box((1, 1, 1)), box((0.2, 0.2, 0.2))])
    assert len(triangles) == 12
    np.testing.assert_allclose(np.abs(points), 0.5)


def test_a_sealed_cavity_touches_nothing():
    outer, inner = cube_solid(), cube_solid(0.5)
    hollow = Solid(
        np.concatenate([outer.points, inner.points]),
        np.concatenate([outer.triangles, inner.triangles[:, ::-1] + 8]).astype(np.int32),
        "closed",
    )
    assert len(outer_surface(hollow)[1]) == 12
    f = measure_fidelity("box", [box((1, 1, 1))], hollow, [])
    assert f.volume_ratio == pytest.approx(1.0)
    assert f.missing_max <= SLACK


def test_a_shell_has_no_volume_ratio():
    cube = cube_solid()
    f = measure_fidelity("box", [box((1, 1, 1))], Solid(cube.points, cube.triangles[2:], "shell", 0.01), [])
    assert f.volume_ratio is None


def test_no_shapes_is_a_bug():
    with pytest.raises(ValueError, match="no shapes"):
        measure_fidelity("none", [], cube_solid(), [])


@pytest.mark.parametrize(("hole_m", "still_open"), [(0.04, True), (0.032, True), (0.016, False), (0.0, False)])
def test_a_drain_that_has_become_narrow_is_a_lost_opening(hole_m: float, still_open: bool):
    """A basin of 30 cm, walls and floor of 1 cm, with a drain of 4 cm: 60 % of the widest ball must still pass."""
    basin = Manifold.cube((0.3, 0.3, 0.1), center=True) - Manifold.cube((0.28, 0.28, 0.1), center=True).translate(
        (0.0, 0.0, 0.01)
    )
    points, triangles = manifold_arrays(basin - Manifold.cube((0.04, 0.04, 0.2), center=True))
    solid = Solid(points, triangles.astype(np.int32), "closed")
    shapes = [box((0.01, 0.3, 0.1), (side * 0.145, 0.0, 0.0)) for side in (-1, 1)]
    shapes += [box((0.3, 0.01, 0.1), (0.0, side * 0.145, 0.0)) for side in (-1, 1)]
    board, middle = 0.5 * (0.3 - hole_m), 0.25 * (0.3 + hole_m)
    shapes += [box((board, 0.3, 0.01), (side * middle, 0.0, -0.045)) for side in (-1, 1)]
    shapes += [box((0.3, board, 0.01), (0.0, side * middle, -0.045)) for side in (-1, 1)]
    cavities = find_cavities(solid)
    assert len(cavities) == 1
    assert cavities[0].second_m == pytest.approx(0.6 * 0.02, rel=0.15)
    assert measure_fidelity("boards", shapes, solid, cavities).cavity_kept is still_open
