"""Surfaces to stand on: closed forms on furniture of known measures, and laws under yaw, size and tessellation."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from manifold3d import CrossSection, FillRule, Manifold
from shapely.affinity import rotate, scale

from geom.features.support_surfaces import SupportFace, find_supports
from schemas.physics import Solid
from tests.support.furniture import block, open_box, shelf, solid_of, table

UP = [0.0, 0.0, 1.0]


def sides(support: SupportFace) -> set[tuple[float, ...]]:
    return {tuple(np.round(side, 6) + 0.0) for side in support.load_directions}


def same(polygon: shapely.Polygon, other: shapely.Polygon) -> bool:
    return polygon.symmetric_difference(other).area < 1e-5 * polygon.area


def test_faces_that_overlap_in_plan_are_joined():
    """Two wedges with a corner in common that were never united: GEOS refuses to join such faces as neighbours."""
    outlines = [[(0.1, 0.2), (0.3, 0.1), (0.1, 0.3)], [(0.3, 0.3), (0.1, 0.2), (0.3, 0.2)]]
    with pytest.raises(shapely.errors.GEOSException):
        shapely.coverage_union_all([shapely.Polygon(o) for o in outlines])
    one, other = (solid_of(Manifold.extrude(CrossSection([np.array(o)], FillRule.NonZero), 0.02)) for o in outlines)
    points = np.concatenate([one.points, other.points])
    triangles = np.concatenate([one.triangles, other.triangles + np.int32(len(one.points))])
    (top,) = find_supports(Solid(points, triangles, "closed"))
    assert top.polygon.area == pytest.approx(shapely.union_all([shapely.Polygon(o) for o in outlines]).area, rel=1e-3)


def test_a_table_has_its_top():
    (top,) = find_supports(solid_of(table(1.2, 0.8, 0.75)))
    assert same(top.polygon, shapely.box(-0.6, -0.4, 0.6, 0.4))
    assert top.height_m == pytest.approx(0.75)
    assert top.clearance_m is None
    assert top.normal == pytest.approx(UP)
    assert sides(top) == {(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)}


def test_a_shelf_has_its_boards_each_with_the_clearance_below_the_next_and_open_to_the_front():
    found = find_supports(solid_of(shelf((0.02, 0.42, 0.92), top=1.2)))
    assert [s.height_m for s in found] == pytest.approx([1.2, 0.92, 0.42, 0.02])
    assert found[0].clearance_m is None
    assert [s.clearance_m for s in found[1:]] == pytest.approx([0.26, 0.48, 0.38], rel=1e-5)
    for board in found[1:]:
        assert sides(board) == {(0, -1, 0)}
        assert same(board.polygon, shapely.box(-0.38, -0.15, 0.38, 0.13))


def test_doors_close_a_cupboard():
    closed = shelf() + block(0.8, 0.02, 1.2, (0, -0.16, 0))
    assert [s.height_m for s in find_supports(solid_of(closed))] == pytest.approx([1.2])


def test_what_stands_on_a_top_is_a_hole_in_it():
    lamp = table() + block(0.12, 0.12, 0.3, (0.2, 0.1, 0.75))
    top = next(s for s in find_supports(solid_of(lamp)) if s.height_m == pytest.approx(0.75))
    assert len(top.polygon.interiors) == 1
    hole = shapely.Polygon(top.polygon.interiors[0])
    assert same(hole, shapely.box(0.14, 0.04, 0.26, 0.16))


def test_a_top_is_cut_where_another_hangs_over_it():
    desk = table() + block(0.4, 0.8, 0.02, (0.4, 0, 1.1)) + block(0.02, 0.8, 0.4, (0.59, 0, 0.74))
    free, under = (s for s in find_supports(solid_of(desk)) if s.height_m == pytest.approx(0.75))
    assert free.clearance_m is None
    assert under.clearance_m == pytest.approx(0.35, rel=1e-5)
    assert free.polygon.intersection(under.polygon).area < 1e-6
    assert free.polygon.bounds[2] == pytest.approx(0.2, abs=0.04)


def test_planks_bumps_and_a_low_rim_are_one_surface():
    planks = [block(0.8, 0.09, 0.03, (0, 0.1 * k, 0.4 + 0.004 * (k % 2))) for k in range(-2, 3)]
    body = Manifold.compose(planks)
    (top,) = find_supports(solid_of(body))
    assert top.polygon.area == pytest.approx(0.8 * 0.49, rel=0.02)
    assert top.height_m == pytest.approx(0.434)  # a thing stands on the higher ones
    (floor,) = find_supports(solid_of(open_box(0.4, 0.3, 0.03, 0.01)))
    assert floor.polygon.area == pytest.approx(0.38 * 0.28, rel=0.03)


@pytest.mark.parametrize(
    "body",
    [
        Manifold.sphere(0.1, 64),
        Manifold.sphere(0.1, 64).scale((1.0, 1.4, 0.8)),
        Manifold.cylinder(0.3, 0.05, 0.05, 48).rotate((90, 0, 0)),
        Manifold.cylinder(0.3, 0.1, 0.0, 48),
        block(0.5, 0.5, 0.1).rotate((15, 0, 0)),
        open_box(0.4, 0.3, 0.3, 0.01) - block(0.38, 0.28, 0.02),  # only a rim
    ],
    ids=["ball", "egg", "lying cylinder", "cone", "ramp", "frame"],
)
def test_round_steep_and_narrow_things_have_none(body):
    assert find_supports(solid_of(body)) == ()


@pytest.mark.parametrize("yaw_deg", [20.0, 90.0, 200.0])
@pytest.mark.parametrize("body", [table(), shelf()], ids=["table", "shelf"])
def test_turning_about_the_vertical_turns_the_surfaces_along(body, yaw_deg):
    before = find_supports(solid_of(body))
    after = find_supports(solid_of(body, yaw_rad=np.radians(yaw_deg)))
    assert len(after) == len(before)
    for a, b in zip(before, after, strict=True):
        assert b.polygon.symmetric_difference(rotate(a.polygon, yaw_deg, origin=(0, 0))).area < 1e-4 * a.polygon.area
        assert (a.clearance_m is None) == (b.clearance_m is None)
        assert len(a.load_directions) == len(b.load_directions)


@pytest.mark.parametrize("size", [1e-3, 40.0])
def test_scaling_scales(size):
    before, after = find_supports(solid_of(shelf())), find_supports(solid_of(shelf(), scale=size))
    for a, b in zip(before, after, strict=True):
        assert b.polygon.symmetric_difference(scale(a.polygon, size, size, origin=(0, 0))).area < 1e-4 * b.polygon.area
        assert b.height_m == pytest.approx(size * a.height_m)


def test_tessellation_does_not_matter():
    (top,) = find_supports(solid_of(table().refine(7)))
    assert same(top.polygon, shapely.box(-0.6, -0.4, 0.6, 0.4))
