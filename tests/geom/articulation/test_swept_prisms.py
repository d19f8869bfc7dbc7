"""Swept prisms contain every point of the body at every position, and are not much larger than what it sweeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from geom.articulation.swept_prisms import Prism, Sweep, swept_prisms
from geom.pose import apply, pose, rotation_about

POSITIONS = 24


def turn(axis: np.ndarray, anchor: np.ndarray):
    def motion(q: float) -> np.ndarray:
        R = rotation_about(axis, q)
        return pose(R, anchor - R @ anchor)

    return motion


def held(prisms: tuple[Prism, ...], points: np.ndarray) -> np.ndarray:
    inside = np.zeros(len(points), dtype=bool)
    for prism in prisms:
        level = (points[:, 2] >= prism.low_m) & (points[:, 2] <= prism.high_m)
        inside[level] |= shapely.contains_xy(prism.polygon.buffer(1e-12), points[level, 0], points[level, 1])
    return inside


def body_points(corners: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    weights = rng.dirichlet(np.full(len(corners), 0.15), size=60)
    return np.concatenate([corners, weights @ corners])


boxes = st.tuples(*[st.floats(0.01, 0.5)] * 3, *[st.floats(-0.4, 0.4)] * 3)
directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.2)


def corners_of(numbers: tuple[float, ...]) -> np.ndarray:
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return signs * numbers[:3] + numbers[3:]


@settings(max_examples=6, deadline=None)
@given(
    st.lists(boxes, min_size=1, max_size=3),
    directions,
    st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    st.floats(-2.0, 1.0),
    st.floats(0.05, 6.5),
    st.booleans(),
)
def test_every_point_at_every_position_lies_inside(bodies, direction, anchor, low, span, slides) -> None:
    axis = np.array(direction) / np.linalg.norm(direction)
    motion = (lambda q: pose(None, q * axis)) if slides else turn(axis, np.array(anchor))
    line = {} if slides else {"axis": axis, "anchor": np.array(anchor)}
    rng = np.random.default_rng(0)
    corners = [corners_of(numbers) for numbers in bodies]
    prisms, volume = swept_prisms([Sweep(c, motion, (low, low + span), **line) for c in corners])
    for c in corners:
        points = body_points(c, rng)
        for q in np.linspace(low, low + span, POSITIONS):
            assert held(prisms, apply(motion(q), points)).all()
    assert volume == pytest.approx(sum(p.polygon.area * (p.high_m - p.low_m) for p in prisms))


def sampled_volume(corners: np.ndarray, motion, limits: tuple[float, float], prisms: tuple[Prism, ...]) -> float:
    """Volume that a box sweeps, by random points of the box around the prisms and dense positions: a lower bound."""
    low = np.min([[*p.polygon.bounds[:2], p.low_m] for p in prisms], axis=0)
    high = np.max([[*p.polygon.bounds[2:], p.high_m] for p in prisms], axis=0)
    points = np.random.default_rng(1).uniform(low, high, size=(20000, 3))
    lowest, highest = corners.min(axis=0), corners.max(axis=0)
    swept = np.zeros(len(points), dtype=bool)
    for q in np.linspace(*limits, 200):
        local = apply(np.linalg.inv(motion(q)), points)
        swept |= ((local >= lowest) & (local <= highest)).all(axis=1)
    return float(swept.mean() * np.prod(high - low))


DOOR = corners_of((0.5, 0.02, 0.9, 0.25, 0.0, 0.45))
LID = corners_of((0.5, 0.4, 0.02, 0.0, -0.2, 0.3))
DRAWER = corners_of((0.4, 0.35, 0.12, 0.0, 0.0, 0.1))


@pytest.mark.parametrize(
    ("corners", "axis", "anchor", "limits", "most"),
    [
        (DOOR, (0, 0, 1), (0, 0, 0), (0.0, 1.6), 1.05),
        (LID, (1, 0, 0), (0, 0, 0.3), (-1.6, 0.0), 1.2),
        (DOOR, (1, 0, 0), (0, 0, 0), (0.0, 1.5), 1.1),
    ],
    ids=["door", "lid", "flap"],
)
def test_the_cover_of_a_turn_is_tight(corners, axis, anchor, limits, most) -> None:
    line, point = np.array(axis, dtype=float), np.array(anchor, dtype=float)
    motion = turn(line, point)
    prisms, volume = swept_prisms([Sweep(corners, motion, limits, line, point)])
    ratio = volume / sampled_volume(corners, motion, limits, prisms)
    assert 1.0 <= ratio <= most, ratio


def test_the_cover_of_a_slide_is_its_box() -> None:
    def motion(q: float) -> np.ndarray:
        return pose(None, np.array([0.0, -q, 0.0]))

    prisms, volume = swept_prisms([Sweep(DRAWER, motion, (0.0, 0.3))])
    assert len(prisms) == 1
    assert volume == pytest.approx(0.4 * 0.65 * 0.12, rel=0.03)


def test_a_bound_on_the_speed_covers_a_motion_that_is_no_single_turn() -> None:
    """A tray that slides while its carrier turns."""
    corners = corners_of((0.1, 0.1, 0.05, 0.2, 0.0, 0.0))

    def motion(q: float) -> np.ndarray:
        return turn(np.array([0.0, 0.0, 1.0]), np.zeros(3))(q) @ pose(None, np.array([0.1 * q, 0.0, 0.0]))

    speed = 0.1 + float(np.linalg.norm(corners, axis=1).max()) + 0.15
    prisms, _ = swept_prisms([Sweep(corners, motion, (0.0, 1.5), exact=False, speed=speed)])
    points = body_points(corners, np.random.default_rng(0))
    for q in np.linspace(0.0, 1.5, POSITIONS):
        assert held(prisms, apply(motion(q), points)).all()


def test_a_wide_turn_is_a_ring() -> None:
    corners = corners_of((0.1, 0.1, 0.1, 0.5, 0.0, 0.05))
    axis = np.array([0.0, 0.0, 1.0])
    prisms, volume = swept_prisms([Sweep(corners, turn(axis, np.zeros(3)), (0.0, 2.0 * math.pi), axis, np.zeros(3))])
    inner, outer = 0.45, math.hypot(0.55, 0.05)
    assert volume == pytest.approx(math.pi * (outer**2 - inner**2) * 0.1, rel=0.1)
    assert not held(prisms, np.array([[0.0, 0.0, 0.05]])).any(), "the middle stays free"


def test_without_any_spare_the_cover_still_holds_the_arcs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the positions at which hulls are taken the corners lie outside of the chords."""
    monkeypatch.setattr("geom.articulation.swept_prisms.SPARE_SHARE", 0.0)
    axis = np.array([0.0, 0.0, 1.0])
    motion = turn(axis, np.zeros(3))
    prisms, _ = swept_prisms([Sweep(DOOR, motion, (0.0, 1.6), axis, np.zeros(3))])
    for q in np.linspace(0.0, 1.6, 181):
        assert held(prisms, apply(motion(q), DOOR)).all(), q
