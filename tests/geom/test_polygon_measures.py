"""Distances, areas and bounds of arrays of geometries agree with those of the geometries one by one."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Point, box

from geom.polygon_measures import areas, bounds, distances

SQUARES = [box(0.0, 0.0, 1.0, 1.0), box(3.0, 0.0, 5.0, 1.0)]


def test_distances_broadcast() -> None:
    assert distances(SQUARES, Point(2.0, 0.5)).tolist() == [1.0, 1.0]
    assert distances(shapely.points([[2.0, 0.5], [1.5, 0.5]]), SQUARES[0]).tolist() == [1.0, 0.5]


def test_areas_and_bounds_are_floats_by_row() -> None:
    assert areas([*SQUARES, Point(0.0, 0.0)]).tolist() == [1.0, 2.0, 0.0]
    assert bounds(SQUARES).tolist() == [[0.0, 0.0, 1.0, 1.0], [3.0, 0.0, 5.0, 1.0]]
    assert np.isnan(bounds([shapely.Polygon()])).all()
