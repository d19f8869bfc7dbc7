"""Points drawn from regions that have lost a dimension."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, Point, Polygon, box

from scenec.solve.points import sample_point

SLIVER = Polygon([(0.0, 0.0), (0.2, 0.0), (0.2, 1e-17)])


@pytest.mark.parametrize(
    "region", [box(0.0, 0.0, 0.2, 0.1), SLIVER, LineString([(0.0, 0.0), (0.2, 0.0)]), Point(0.1, 0.0)]
)
def test_a_point_is_drawn_from_what_is_left(region):
    point = sample_point(region, np.random.default_rng(0))
    assert point is not None
    assert region.distance(Point(point)) < 1e-12
