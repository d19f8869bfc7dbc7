"""What is inside a crate, above its rim or outside, and which paths lead through a wall."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.affordances.inside import Inside
from schemas.anchors import AnchorPolygon
from tests.assetkit.acceptance.suites.crates import HEIGHT, LENGTH, WALL, inside

INSIDE = Inside(inside())
MIDDLE, ABOVE, BESIDE = (0.0, 0.0, 0.05), (0.0, 0.0, 0.2), (0.2, 0.0, 0.05)
BELOW, OVER_WALL = (0.0, 0.0, -0.05), (0.08, 0.0, 0.2)


@pytest.mark.parametrize(
    ("point", "contained"),
    [
        (MIDDLE, True),
        (ABOVE, False),
        (BESIDE, False),
        (BELOW, False),
        ((0.5 * LENGTH + 0.002, 0.0, 0.05), True),  # within the tolerance of colliders
        ((0.5 * LENGTH + 0.004, 0.0, 0.05), False),
        ((0.0, 0.0, WALL + HEIGHT), True),
        ((float("nan"), 0.0, 0.05), False),
        ((0.0, 0.0, float("nan")), False),
    ],
)
def test_a_point_is_inside_between_walls_floor_and_rim(point: tuple[float, float, float], contained: bool) -> None:
    assert INSIDE.contains(np.array([point]), 0.003).tolist() == [contained]


@pytest.mark.parametrize(
    ("path", "through"),
    [
        ((ABOVE, MIDDLE, MIDDLE), False),
        ((ABOVE, MIDDLE, BESIDE), True),
        ((ABOVE, MIDDLE, BELOW), True),
        ((MIDDLE, BELOW, MIDDLE), False),  # It sank in, and was pushed back.
        ((MIDDLE, ABOVE, OVER_WALL, BESIDE), False),  # It left over the rim,
        ((ABOVE, OVER_WALL, BESIDE), False),  # or never was inside.
    ],
)
def test_only_paths_that_end_outside_without_passing_the_rim_lead_through_a_wall(
    path: tuple[tuple[float, float, float], ...], through: bool
) -> None:
    assert INSIDE.left_through_wall(np.array(path)[:, None], 0.003).tolist() == [through]


def test_a_ball_rests_on_the_floor_clear_of_walls() -> None:
    assert INSIDE.resting_height((0.0, 0.0), 0.01) == pytest.approx(WALL + 0.011)
    assert INSIDE.resting_height((0.5 * LENGTH - 0.005, 0.0), 0.01) >= WALL + HEIGHT  # no room below the rim


def test_things_get_in_where_the_opening_lies_over_the_uppermost_layer() -> None:
    volume = inside()
    neck = AnchorPolygon(outline_m=((0.01, -0.02), (0.05, -0.02), (0.05, 0.02), (0.01, 0.02)))
    upper = volume.slices[-1].model_copy(update={"polygons": (neck,)})
    narrowed = Inside(volume.model_copy(update={"slices": (*volume.slices[:-1], upper)}))
    assert narrowed.opening.bounds == pytest.approx((0.01, -0.02, 0.05, 0.02))
    assert narrowed.resting_height((0.03, 0.0), 0.01) == pytest.approx(WALL + 0.011)
