"""Footprints of many pieces: their no-fit polygons, and layers of them in a receptacle."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from shapely import MultiPoint, Polygon, box, union_all

from scenec.check.judge_scene import violations
from scenec.ir.problem import Body, Exhausted, Solved
from scenec.solve import solve
from scenec.solve.planar import hull_of
from scenec.solve.region_geometry import FEW_CORNERS, minkowski_sum_points
from scenec.solve.shapes import COARSE_SHARE, shape_of
from schemas.scene.geometry import PlaceLayer, Prism, ScenePlace, Stance
from tests.support.scene.proof_problems import problem, thing

WALLS = 12


def mug() -> Body:
    """8 cm wide, 9 cm high: a bottom, twelve pieces of wall and a handle to 6.5 cm from the axis."""
    at = np.arange(WALLS + 1) * 2.0 * np.pi / WALLS
    inner, outer = (r * np.stack([np.cos(at), np.sin(at)], axis=1) for r in (0.036, 0.04))
    walls = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(WALLS)]
    handle = np.array([(0.038, -0.006), (0.065, -0.006), (0.065, 0.006), (0.038, 0.006)])
    prisms = [Prism(outer[:-1], 0.0, 0.005), *(Prism(wall, 0.0, 0.09) for wall in walls), Prism(handle, 0.02, 0.07)]
    return Body("mug", (Stance((1.0, 0.0, 0.0, 0.0), tuple(prisms), 0.0),))


def mugs_in(length_m: float, width_m: float, count: int):
    area = box(-length_m / 2, -width_m / 2, length_m / 2, width_m / 2)
    inside = ScenePlace.volume("inside", (PlaceLayer(0.0, 0.25, area),), area, np.zeros(3))
    return problem([thing(f"m{k}", mug(), inside, yaw=(-np.pi, np.pi)) for k in range(count)], clearance=0.003)


@given(st.integers(0, 2**32 - 1), st.integers(3, 40), st.integers(3, 40))
def test_going_round_two_outlines_finds_their_whole_sum(seed: int, n: int, k: int):
    rng = np.random.default_rng(seed)
    one, two = hull_of(rng.normal(size=(n, 2))), hull_of(rng.normal(size=(k, 2)))
    every = MultiPoint((one[:, None] - two[None]).reshape(-1, 2)).convex_hull
    found = MultiPoint(minkowski_sum_points(one, two)).convex_hull
    assert found.symmetric_difference(every).area <= 1e-12 * every.area
    assert len(one) * len(two) <= FEW_CORNERS or len(minkowski_sum_points(one, two)) == len(one) + len(two)


def test_broad_pieces_are_few_and_hold_the_footprint_and_little_more():
    shape = shape_of(mug().resting_orientations[0])
    broad, whole = (union_all([Polygon(piece) for piece in pieces]) for pieces in (shape.coarse_pieces, shape.pieces))
    assert len(shape.coarse_pieces) <= 3
    assert broad.buffer(1e-9).covers(whole)
    assert broad.area - whole.area <= len(shape.pieces) * COARSE_SHARE * shape.area_m2


def test_mugs_stand_in_two_layers_where_the_floor_is_full():
    asked = mugs_in(0.28, 0.22, 8)
    found = solve(asked, 0)
    assert isinstance(found, Solved), found
    assert violations(asked, found.placements) == ()
    assert sum(at.base_m > 0.05 for at in found.placements.values()) >= 1


def test_too_many_mugs_end_within_their_steps_and_name_one():
    ended = solve(mugs_in(0.2, 0.15, 12), 0, budget=600)
    assert isinstance(ended, Exhausted)
    assert ended.blocking.startswith("m")
