"""Regions and points of them, however thin."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from scenec.solve.points import sample_point
from scenec.solve.region_geometry import half_plane
from scenec.solve.regions import eroded

SLIVER = Polygon([(0, 0), (1, 1e-17), (1, 2e-17)])


@pytest.mark.parametrize(
    "region",
    [
        box(0, 0, 1, 2),
        MultiPolygon([box(0, 0, 1, 1), box(2, 0, 3, 1)]),
        LineString([(0, 0), (1, 1)]),
        Point(0.5, 0.5),
        SLIVER,
        shapely.GeometryCollection([SLIVER, Point(3, 3)]),
    ],
    ids=["box", "two boxes", "line", "point", "sliver", "sliver and point"],
)
def test_a_point_lies_in_its_region(region: BaseGeometry):
    point = sample_point(region, np.random.default_rng(0))
    assert point is not None
    assert region.distance(Point(point)) < 1e-12


def test_nowhere_has_no_point():
    assert sample_point(Polygon(), np.random.default_rng(0)) is None


def test_a_footprint_at_any_point_of_an_eroded_region_lies_on_the_place_and_beyond_it_does_not():
    place = Polygon(box(0, 0, 1, 1).exterior, [box(0.4, 0.4, 0.6, 0.7).exterior])
    corner_piece = [
        np.array([(0, 0), (0.2, 0), (0.2, 0.05), (0, 0.05)]),
        np.array([(0, 0), (0.05, 0), (0.05, 0.2), (0, 0.2)]),
    ]
    region = eroded(place, corner_piece)
    rng = np.random.default_rng(0)
    for x, y in rng.random((400, 2)):
        fits = all(place.covers(Polygon(np.add(piece, (x, y)))) for piece in corner_piece)
        assert fits == region.covers(Point(x, y))


@pytest.mark.parametrize("end", [-50.0, 0.3, 50.0])
def test_a_half_plane_keeps_the_part_of_the_box_before_its_border(end: float):
    around = box(0, 0, 1, 1)
    kept = around.intersection(half_plane(1.0, 0.0, end, around.bounds))
    assert kept.area == pytest.approx(min(max(end, 0.0), 1.0))
