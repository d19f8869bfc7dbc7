"""Rims, spouts, handles and holes of simple things; what is not there is not stated."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold
from scipy.spatial.transform import Rotation

from assetkit.affordances.anchors import propose_anchors
from assetkit.affordances.regions import find_regions, is_handle, upright_requirement
from geom.features.cavities import find_cavities
from geom.features.elongated_ends import find_elongated_end
from geom.features.spouts import find_spout
from geom.features.through_holes import find_through_holes, genus
from geom.mesh.manifold_arrays import manifold_arrays
from schemas.evidence import measured
from schemas.physics import Solid
from tests.assetkit.colliders.test_choose_keeps_openings import bowl, mug


def solid_of(manifold: Manifold, R: np.ndarray | None = None, scale: float = 1.0) -> Solid:
    points, triangles = manifold_arrays(manifold)
    return Solid(scale * points @ (np.eye(3) if R is None else R).T, triangles, "closed")


def kinds(manifold: Manifold) -> list[str]:
    solid = solid_of(manifold)
    anchors = [measured(a, "test") for a in propose_anchors(solid, find_cavities(solid))]
    return sorted(e.value.kind for e in find_regions(solid, anchors, ()))


def pan() -> Manifold:
    body = Manifold.cylinder(0.04, 0.1, 0.11, 48) - Manifold.cylinder(0.04, 0.095, 0.105, 48).translate((0, 0, 0.005))
    handle = Manifold.cube((0.18, 0.025, 0.012)).translate((0.1, -0.0125, 0.025))
    hole = Manifold.cylinder(0.1, 0.006, 0.006, 24).translate((0.265, 0, -0.02))
    return body + handle - hole


def jug() -> Manifold:
    angles = np.arange(96) * 2 * np.pi / 96
    radius = 0.05 + 0.018 * np.maximum(0, np.cos(angles)) ** 12
    outline = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    outer, inner = CrossSection([outline.tolist()]), CrossSection([(0.92 * outline).tolist()])
    return Manifold.extrude(outer, 0.15) - Manifold.extrude(inner, 0.15).translate((0, 0, 0.006))


def test_a_mug_has_a_rim_a_handle_and_hangs_by_it():
    assert kinds(mug()) == ["handle", "hang_hole", "rim"]


def test_a_bowl_has_a_rim_only():
    assert kinds(bowl()) == ["rim"]


def test_a_block_offers_nothing():
    assert kinds(Manifold.cube((0.05, 0.06, 0.1))) == []


def test_a_ring_hangs_but_has_no_handle():
    ring = Manifold.revolve(CrossSection.circle(0.01, 24).translate((0.05, 0)), 48)
    assert kinds(ring) == ["hang_hole"]


def test_a_pan_is_held_by_its_grip_and_hangs_by_the_hole_in_it():
    assert kinds(pan()) == ["handle", "hang_hole", "rim"]


def test_a_jug_pours_over_its_lip():
    solid = solid_of(jug())
    anchors = [measured(a, "test") for a in propose_anchors(solid, find_cavities(solid))]
    spouts = [e.value for e in find_regions(solid, anchors, ()) if e.value.kind == "spout"]
    assert len(spouts) == 1
    assert np.array(spouts[0].direction) == pytest.approx([1.0, 0.0, 0.0], abs=0.1)
    assert spouts[0].orientation is not None
    assert spouts[0].orientation.toward == "down"


@pytest.mark.parametrize("sides", [3, 4, 6, 64])
def test_regular_rims_have_no_lip(sides: int):
    angles = np.arange(sides) * 2 * np.pi / sides
    assert find_spout(np.stack([np.cos(angles), 0.6 * np.sin(angles), 0 * angles], axis=1)) is None


@pytest.mark.parametrize("seed", range(6))
def test_a_handle_is_found_however_the_mug_is_turned(seed: int):
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    holes = find_through_holes(solid_of(mug(), R))
    assert sum(is_handle(h) for h in holes) == 1
    hole = next(h for h in holes if is_handle(h))
    # The ring of radius 28 mm stands around x = 40 mm on the mug.
    assert hole.bar_at_m @ R == pytest.approx([0.068, 0.0, 0.05], abs=0.008)


def test_holes_scale_with_the_thing_but_hands_do_not():
    assert not any(is_handle(h) for h in find_through_holes(solid_of(mug(), scale=0.1)))
    assert find_through_holes(solid_of(mug(), scale=0.1))[0].diameter_m == pytest.approx(
        0.1 * find_through_holes(solid_of(mug()))[0].diameter_m, rel=1e-3
    )


@pytest.mark.parametrize(
    ("thing", "handles"), [(Manifold.sphere(1.0, 24), 0), (mug(), 1), (Manifold.cube((1, 1, 1)), 0)]
)
def test_genus(thing: Manifold, handles: int):
    assert genus(manifold_arrays(thing)[1]) == handles


def test_two_balls_have_no_handle_together():
    points, triangles = manifold_arrays(Manifold.sphere(1.0, 12))
    assert genus(np.concatenate([triangles, triangles + len(points)])) == 0


@pytest.mark.parametrize("seed", range(4))
def test_a_grip_is_found_however_the_thing_is_turned_and_points_to_its_free_end(seed: int):
    hammer = Manifold.cube((0.25, 0.025, 0.025)).translate((0, -0.0125, -0.0125))
    hammer += Manifold.cube((0.03, 0.12, 0.03)).translate((0.25, -0.06, -0.015))
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    grip = find_elongated_end(solid_of(hammer, R))
    assert grip is not None
    assert (grip.axis_m[-1] @ R)[0] < (grip.axis_m[0] @ R)[0]


@pytest.mark.parametrize(
    "thing", [Manifold.cylinder(0.2, 0.08, 0.002, 32), Manifold.cylinder(0.2, 0.02, 0.02, 32), Manifold.sphere(0.1, 32)]
)
def test_cones_rods_and_balls_have_no_grip(thing: Manifold):
    assert find_elongated_end(solid_of(thing)) is None


def test_an_open_vessel_is_carried_upright():
    solid = solid_of(bowl())
    anchors = [measured(a, "test") for a in propose_anchors(solid, find_cavities(solid))]
    upright = upright_requirement(anchors)
    assert upright is not None
    assert upright.toward == "up"
    assert upright_requirement(()) is None
