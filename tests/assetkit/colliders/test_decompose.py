"""Decomposition fills the body with few convex hulls, repeats itself bit by bit, and fails with a reason."""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
import pytest
import shapely
import trimesh
from manifold3d import CrossSection, Manifold

from assetkit.colliders.decompose import DecompositionSettings, decompose
from geom.convex.hull import contains, thickness, volume
from geom.decomposition.fidelity import union_volume
from geom.decomposition.simplified_body import SimplifiedBody, simplify_body
from geom.features.cavities import find_cavities, keeps_cavity
from geom.mesh.manifold_arrays import manifold_arrays
from geom.solid.thicken import thicken
from jobs.cell import Limits
from schemas.physics import Solid
from tests.support.present import present

CUTS, COACD, VHACD = (
    DecompositionSettings(method="cuts"),
    DecompositionSettings(),
    DecompositionSettings(method="vhacd", voxels=50_000),
)


def ell() -> Manifold:
    return Manifold.cube((0.2, 0.05, 0.05)) + Manifold.cube((0.05, 0.05, 0.3))


def cup() -> Manifold:
    return Manifold.cylinder(0.1, 0.04, 0.04, 24) - Manifold.cylinder(0.1, 0.035, 0.035, 24).translate((0, 0, 0.005))


def body_of(shape: Manifold, scale: float = 1.0, shift: float = 0.0) -> SimplifiedBody:
    points, triangles = manifold_arrays(shape)
    return simplify_body(points * scale + shift, triangles.astype(np.int32))


def same(a, b) -> bool:
    return len(a) == len(b) and all(np.array_equal(x.points, y.points) for x, y in zip(a, b, strict=True))


SECTORS = DecompositionSettings(method="sectors", sector_planes=8)


def ring(section: CrossSection, radius: float) -> Manifold:
    return Manifold.revolve(section.translate((radius, 0.0)), 96)


RINGS = {
    "washer": ring(CrossSection.square((0.02, 0.01), True), 0.03),
    "torus": ring(CrossSection.circle(0.012, 24), 0.03),
}
TURNS = {"washer": (0.0, 0.0, 0.0), "torus": (0.0, 90.0, 0.0)}
INNER_M = {"washer": 0.02, "torus": 0.018}


@pytest.mark.parametrize("name", RINGS)
def test_sectors_of_a_ring_leave_its_hole_open_up_to_their_chords(tmp_path, name: str):
    turn = TURNS[name]
    body = RINGS[name].rotate(turn)
    points, triangles = manifold_arrays(body)
    cavities = find_cavities(Solid(points, triangles.astype(np.int32), "closed"))
    parts = decompose(body_of(body), SECTORS, tmp_path, cavities)
    assert (len(parts.shapes), parts.reason) == (16, "")
    axis = np.array([1.0, 0.0, 0.0]) if turn[1] else np.array([0.0, 0.0, 1.0])
    outlines = (shapely.MultiPoint(present(s.points) @ np.linalg.svd(axis[None])[2][1:].T) for s in parts.shapes)
    free_m = min(outline.convex_hull.distance(shapely.Point(0.0, 0.0)) for outline in outlines)
    assert free_m >= 0.97 * INNER_M[name]
    assert union_volume(parts.shapes) == pytest.approx(body.volume(), rel=0.03)


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (ring(CrossSection.square((0.03, 0.01), True) + CrossSection.square((0.005, 0.05), True), 0.03), "hulls of"),
        (ring(CrossSection.square((0.003, 0.02), True), 0.05), "hulls of"),
        (cup(), "nothing is open"),
    ],
    ids=["a section that is not convex", "a wall as thin as a chord is deep", "a vessel"],
)
def test_sectors_are_for_rings_of_convex_section(tmp_path, body: Manifold, reason: str):
    points, triangles = manifold_arrays(body)
    cavities = find_cavities(Solid(points, triangles.astype(np.int32), "closed"))
    parts = decompose(body_of(body), SECTORS, tmp_path, cavities)
    assert parts.shapes == ()
    assert reason in parts.reason


@pytest.mark.parametrize("settings", [CUTS, COACD], ids=["cuts", "coacd"])
def test_an_ell_is_two_hulls_twice_the_same_and_far_from_the_origin_too(tmp_path, settings):
    first = decompose(body_of(ell()), settings, tmp_path)
    assert len(first.shapes) == 2
    assert union_volume(first.shapes) == pytest.approx(ell().volume(), rel=0.03)
    assert same(first.shapes, decompose(body_of(ell()), settings, tmp_path).shapes)
    far = decompose(body_of(ell(), shift=1000.0), settings, tmp_path)
    # The input is rounded there, so the search may cut elsewhere.
    assert union_volume(far.shapes) == pytest.approx(union_volume(first.shapes), rel=0.01)
    for shape in first.shapes:
        points, triangles = present(shape.points), present(shape.triangles)
        assert len(points) <= 64
        assert thickness(points, triangles) > 0.01
        assert contains(points, triangles, points, 1e-6).all()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size_m", [1e-6, 1e-4, 100.0, 1e6])
def test_scale_does_not_matter(tmp_path, size_m):
    found = decompose(body_of(ell(), scale=size_m), CUTS, tmp_path)
    assert union_volume(found.shapes) / size_m**3 == pytest.approx(ell().volume(), rel=0.03)


@pytest.mark.parametrize("settings", [CUTS, COACD, VHACD], ids=["cuts", "coacd", "vhacd"])
def test_a_cup_stays_open(tmp_path, settings):
    points, triangles = manifold_arrays(cup())
    cavities = find_cavities(Solid(points, triangles.astype(np.int32), "closed"))
    found = decompose(body_of(cup()), settings, tmp_path, cavities)
    assert 0 < len(found.shapes) <= 32
    assert keeps_cavity(found.shapes, cavities[0])


def test_a_cell_that_is_stopped_gives_a_reason(tmp_path):
    stopped = decompose(body_of(ell()), COACD, tmp_path, limits=Limits(seconds=0.05))
    assert stopped.shapes == ()
    assert "timeout" in stopped.reason
    starved = decompose(body_of(ell()), COACD, tmp_path, limits=Limits(memory_mb=64))
    assert starved.shapes == ()
    assert starved.reason


def test_too_many_separate_parts_give_a_reason(tmp_path):
    crumbs = Manifold.compose([Manifold.cube((0.5, 0.5, 0.5)).translate((k, 0, 0)) for k in range(201)])
    assert "separate parts" in decompose(body_of(crumbs), CUTS, tmp_path).reason


def test_settings_say_version_and_seed():
    assert str(COACD) == f"coacd {version('coacd')}, threshold 0.05, search 15/60/2, seed 0"
    assert version("vhacdx") in str(VHACD)


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
