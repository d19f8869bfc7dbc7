"""Proposed anchors meet the simulator: what holds is kept with its share, what does not is named and left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assetkit.affordances.anchor_trials import verify_anchors
from assetkit.affordances.anchors import propose_anchors
from assetkit.colliders.choose import choose_colliders
from geom.features.cavities import find_cavities
from geom.pose import pose
from schemas.anchors import SupportSurface
from schemas.physics import CollisionShape, Solid
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.port import Simulator
from tests.support.furniture import open_box, shelf, solid_of, table


@pytest.fixture(scope="module", params=["bullet", "fake"])
def simulator(request):
    if request.param == "fake":
        yield FakeSimulator()
        return
    with BulletSimulator() as bullet:
        yield bullet


def proposals(solid: Solid):
    return propose_anchors(solid, find_cavities(solid))


def box(size_m: tuple[float, float, float], at: tuple[float, float, float]) -> CollisionShape:
    return CollisionShape("box", size_m, pose(None, at))


def crate_shapes(x: float, y: float, z: float, wall: float) -> list[CollisionShape]:
    ends = [box((wall, y, z), (i * (x - wall) / 2, 0, z / 2)) for i in (-1, 1)]
    walls = [box((x, wall, z), (0, i * (y - wall) / 2, z / 2)) for i in (-1, 1)]
    return [box((x, y, wall), (0, 0, wall / 2)), *ends, *walls]


@pytest.mark.parametrize("size", [0.01, 1.0, 20.0])
def test_a_crate_keeps_floor_and_inside_at_any_size(size: float, simulator: Simulator):
    measures = (0.4 * size, 0.3 * size, 0.2 * size, 0.01 * size)
    tried = verify_anchors(proposals(solid_of(open_box(*measures))), crate_shapes(*measures), simulator)
    assert [a.value.anchor_id for a in tried.anchors] == ["surface_0", "volume_0"]
    assert all(a.source == "measured" and a.confidence == 1.0 for a in tried.anchors)
    assert tried.diagnostics == ()


def test_a_lid_in_the_colliders_refutes_the_inside(simulator: Simulator):
    lidded = [*crate_shapes(0.4, 0.3, 0.2, 0.01), box((0.4, 0.3, 0.01), (0, 0, 0.195))]
    tried = verify_anchors(proposals(solid_of(open_box(0.4, 0.3, 0.2, 0.01))), lidded, simulator)
    assert "volume_0" not in [a.value.anchor_id for a in tried.anchors]
    assert {d.code for d in tried.diagnostics} == {"asset/anchor-unverified"}
    assert "volume_0" in tried.diagnostics[-1].headline


def test_a_surface_without_a_collider_under_it_is_refuted(simulator: Simulator):
    legs_only = [box((0.06, 0.06, 0.75), (i * 0.55, j * 0.35, 0.375)) for i in (-1, 1) for j in (-1, 1)]
    tried = verify_anchors(proposals(solid_of(table())), legs_only, simulator)
    assert tried.anchors == ()
    assert [d.code for d in tried.diagnostics] == ["asset/anchor-unverified"]
    assert float(tried.diagnostics[0].value or 0.0) < 0.5  # some stand on the legs


def test_a_shelf_keeps_all_boards_on_its_own_colliders(tmp_path: Path):
    solid = solid_of(shelf())
    shapes = choose_colliders(solid, tmp_path).shapes
    with BulletSimulator() as bullet:
        tried = verify_anchors(proposals(solid), shapes, bullet)
        again = verify_anchors(proposals(solid), shapes, bullet)
    assert [a.value.anchor_id for a in tried.anchors] == [f"surface_{i}" for i in range(4)]
    assert [a.value.position_m[2] for a in tried.anchors] == pytest.approx([1.2, 0.92, 0.42, 0.02])
    assert [a.model_dump_json() for a in tried.anchors] == [a.model_dump_json() for a in again.anchors]


def test_a_deep_narrow_vessel_is_a_volume_only():
    kinds = [a.kind for a in proposals(solid_of(open_box(0.1, 0.1, 0.3, 0.004)))]
    assert kinds == ["volume"]


def test_a_hull_that_stands_in_for_a_broken_surface_proposes_nothing():
    solid = solid_of(table())
    assert propose_anchors(Solid(solid.points, solid.triangles, "hull"), ()) == ()


def test_anchor_frames_have_the_axes_of_the_asset_and_lie_in_the_middle_of_the_polygon():
    (top,) = proposals(solid_of(table().translate((0.3, -0.2, 0.0))))
    assert top.position_m == pytest.approx((0.3, -0.2, 0.75), abs=1e-6)
    assert top.quat_wxyz == (1.0, 0.0, 0.0, 0.0)
    assert isinstance(top, SupportSurface)
    outline = np.array(top.polygon.outline_m)
    assert outline.min(axis=0) == pytest.approx([-0.6, -0.4])
    assert outline.max(axis=0) == pytest.approx([0.6, 0.4])
