"""Polygons as few convex outlines: they cover the polygon, and exceed it by no more than was allowed."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box

from geom.convex_outlines import convex_outlines, few_convex_outlines, with_fewer_corners

SECTOR = shapely.Point(0.0, 0.0).buffer(0.5, quad_segs=64).intersection(box(0.0, -1.0, 1.0, 1.0))
ELL = box(0.0, 0.0, 0.4, 0.1).union(box(0.0, 0.0, 0.1, 0.4))
RING = box(0.0, 0.0, 1.0, 1.0).difference(box(0.3, 0.3, 0.7, 0.7))


@st.composite
def stars(draw: st.DrawFn) -> Polygon:
    """A polygon that is star-shaped about the origin, mostly not convex."""
    radii = draw(st.lists(st.floats(0.1, 0.6), min_size=5, max_size=24))
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    return Polygon(np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def is_convex(outline: np.ndarray) -> bool:
    return Polygon(outline).convex_hull.area - Polygon(outline).area < 1e-9


@settings(max_examples=60, deadline=None)
@given(stars(), st.sampled_from([1e-6, 1e-2, 0.1]))
def test_outlines_are_convex_and_cover_the_area(area: Polygon, share: float):
    exact, few = convex_outlines(area), few_convex_outlines(area, share)
    whole = shapely.union_all([Polygon(outline) for outline in few])
    assert all(is_convex(outline) for outline in (*exact, *few))
    assert shapely.union_all([Polygon(outline) for outline in exact]).symmetric_difference(area).area < 1e-9
    assert area.difference(whole).area < 1e-9
    assert len(few) <= len(exact)
    assert (
        shapely.union_all([Polygon(outline) for outline in few]).area <= area.area * (1.0 + share * len(exact)) + 1e-9
    )


@pytest.mark.parametrize(("area", "least"), [(SECTOR, 1), (ELL, 2), (RING, 4)])
def test_few_means_few(area: Polygon, least: int):
    assert len(few_convex_outlines(area, 1e-3)) == least


def test_outlines_run_counter_clockwise():
    for outline in (*convex_outlines(ELL), *few_convex_outlines(RING, 1e-3)):
        assert shapely.is_ccw(shapely.linearrings(np.vstack([outline, outline[:1]])))


@settings(max_examples=60, deadline=None)
@given(stars(), st.sampled_from([1e-3, 1e-2]))
def test_fewer_corners_stay_on_the_safe_side(area: Polygon, by_m: float):
    around, inside = with_fewer_corners(area, by_m), with_fewer_corners(area, -by_m)
    assert around.buffer(1e-9).covers(area)
    assert area.buffer(1e-9).covers(inside)


def test_a_round_border_loses_most_of_its_corners():
    around = with_fewer_corners(SECTOR, 1e-3)
    assert len(shapely.get_coordinates(around)) < 0.33 * len(shapely.get_coordinates(SECTOR))
    assert around.buffer(1e-9).covers(SECTOR)
    assert around.hausdorff_distance(SECTOR) < 2.0e-3 * np.sqrt(2.0)  # a corner of the border moves along both sides
