"""Decomposition covers the body with few convex hulls, repeats itself bit by bit, and fails with a reason."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

from assetkit.decompose import Settings, decompose
from geom.cavity import find_cavities, keeps_cavity
from geom.fidelity import union_volume
from geom.hull import contains, convex_hull, thickness, volume
from geom.merge_hulls import merge_hulls
from geom.thicken import thicken
from jobs.cell import Limits
from schemas.physics import Solid


def arrays(body: Manifold) -> tuple[np.ndarray, np.ndarray]:
    mesh = body.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32)


def ell() -> Manifold:
    return Manifold.cube((0.2, 0.05, 0.05)) + Manifold.cube((0.05, 0.05, 0.3))


def cup() -> Manifold:
    return Manifold.cylinder(0.1, 0.04, 0.04, 24) - Manifold.cylinder(0.1, 0.035, 0.035, 24).translate((0, 0, 0.005))


def same(a, b) -> bool:
    return len(a) == len(b) and all(np.array_equal(x.points, y.points) for x, y in zip(a, b, strict=True))


def test_an_ell_is_two_hulls_twice_the_same_and_far_from_the_origin_too(tmp_path):
    points, triangles = arrays(ell())
    first = decompose(points, triangles, Settings(), tmp_path)
    assert 2 <= len(first.shapes) <= 3
    assert union_volume(first.shapes) == pytest.approx(volume(points, triangles), rel=0.03)
    assert same(first.shapes, decompose(points, triangles, Settings(), tmp_path).shapes)
    far = decompose(points + 1000.0, triangles, Settings(), tmp_path)
    # The input is rounded there, so the search may cut elsewhere.
    assert union_volume(far.shapes) == pytest.approx(union_volume(first.shapes), rel=0.01)
    for shape in first.shapes:
        assert len(shape.points) <= 64
        assert thickness(shape.points, shape.triangles) > 0.01
        assert contains(shape.points, shape.triangles, shape.points, 1e-6).all()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size_m", [1e-4, 100.0])
def test_scale_does_not_matter(tmp_path, size_m):
    points, triangles = arrays(ell())
    found = decompose(points * size_m, triangles, Settings(), tmp_path)
    assert union_volume(found.shapes) == pytest.approx(volume(points, triangles) * size_m**3, rel=0.03)


@pytest.mark.parametrize("settings", [Settings(), Settings(method="vhacd", voxels=50_000)])
def test_a_cup_stays_open_even_with_few_hulls(tmp_path, settings):
    points, triangles = arrays(cup())
    cavities = find_cavities(Solid(points, triangles, "closed"))
    found = decompose(points, triangles, settings, tmp_path, cavities)
    assert 0 < len(found.shapes) <= 32
    assert keeps_cavity(found.shapes, cavities[0])


def test_bad_input_gives_a_reason(tmp_path):
    points, triangles = arrays(ell())
    nan = points.copy()
    nan[0, 0] = np.nan
    assert "not finite" in decompose(nan, triangles, Settings(), tmp_path).reason
    assert "closed manifold" in decompose(points, triangles[1:], Settings(), tmp_path).reason
    assert "closed manifold" in decompose(points, triangles[:, ::-1], Settings(), tmp_path).reason
    assert "extent" in decompose(points * 0.0, triangles, Settings(), tmp_path).reason


def test_a_cell_that_is_stopped_gives_a_reason(tmp_path):
    points, triangles = arrays(ell())
    stopped = decompose(points, triangles, Settings(), tmp_path, limits=Limits(seconds=0.05))
    assert stopped.shapes == ()
    assert "timeout" in stopped.reason
    starved = decompose(points, triangles, Settings(), tmp_path, limits=Limits(memory_mb=64))
    assert starved.shapes == ()
    assert starved.reason


def test_merging_joins_what_adds_no_volume_first():
    def block(x: float, y: float) -> np.ndarray:
        return np.array(trimesh.creation.box((1, 1, 1)).vertices) + np.array([x, y, 0])

    pieces = [block(0, 0), block(1, 0), block(2, 0), block(0, 5)]
    row, alone = sorted(merge_hulls(pieces, 2), key=lambda p: -np.ptp(p[:, 0]))
    assert volume(*convex_hull(row)) == pytest.approx(3.0)
    assert volume(*convex_hull(alone)) == pytest.approx(1.0)
    assert len(merge_hulls(pieces, 1)) == 1
    assert len(merge_hulls(pieces, 1, allowed=lambda p: np.ptp(p[:, 1]) < 2)) == 2


def test_a_thickened_sheet_is_closed_and_has_the_wall_volume():
    box = trimesh.creation.box((0.3, 0.2, 0.15))
    lidless = np.array(box.faces)[np.abs(box.triangles_center[:, 2] - 0.075) > 1e-6]
    points, triangles = thicken(np.array(box.vertices), lidless, 0.002)
    wall = trimesh.Trimesh(points, triangles, process=False)
    assert wall.is_watertight
    assert wall.volume == pytest.approx(0.002 * (0.06 + 2 * 0.045 + 2 * 0.03), rel=0.03)
    np.testing.assert_allclose(np.ptp(points[:, :2], axis=0), [0.302, 0.202], atol=1e-3)


def test_a_card_becomes_a_plate():
    card = np.array([[0, 0, 0], [0.09, 0, 0], [0.09, 0.06, 0], [0, 0.06, 0]], dtype=float)
    points, triangles = thicken(card, np.array([[0, 1, 2], [0, 2, 3]]), 0.001)
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.09, 0.06, 0.001])
    assert volume(points, triangles) == pytest.approx(0.09 * 0.06 * 0.001)
    with pytest.raises(ValueError, match="no area"):
        thicken(card, np.array([[0, 1, 1]]), 0.001)
