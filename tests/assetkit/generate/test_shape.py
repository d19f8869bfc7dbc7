"""Shapes: solids of known volume, and convex pieces that cover the same space and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assetkit.generate.shape import (
    AXES,
    SEGMENTS,
    Shape,
    box,
    cylinder,
    drilled,
    frustum,
    open_box,
    revolved,
    tube,
    union,
)
from geom.convex.hull import contains, convex_hull, volume
from geom.convex.support_function import surface

CIRCLE = 0.5 * SEGMENTS * math.sin(2.0 * math.pi / SEGMENTS)  # area of the polygon in the unit circle

SHAPES: dict[str, tuple[Shape, float]] = {
    "box": (box((0.0, 0.0, 0.0), (0.1, 0.2, 0.3)), 0.006),
    "cylinder": (cylinder(0.1, 0.3, (0.0, 0.0, 0.0), "x"), CIRCLE * 0.01 * 0.3),
    "tube": (tube(0.1, 0.2, 0.05, (0.3, 0.0, 0.0)), CIRCLE * 0.03 * 0.05),
    "box open above": (open_box((0.0, 0.0, 0.0), (0.1, 0.2, 0.3), 0.01), 0.006 - 0.08 * 0.18 * 0.29),
    "box open in front": (open_box((0.0, 0.0, 0.0), (0.1, 0.2, 0.3), 0.01, "+x"), 0.006 - 0.09 * 0.18 * 0.28),
    "frustum": (frustum(np.array([0.1, 0.1]), np.array([0.2, 0.2]), 0.0, 0.3), 0.3 / 3.0 * (0.01 + 0.04 + 0.02)),
    "plate with holes": (
        drilled((-0.1, -0.2, 0.0), (0.1, 0.2, 0.02), [(0.0, -0.1, 0.05), (0.0, 0.1, 0.05)]),
        0.2 * 0.4 * 0.02 - 2.0 * CIRCLE * 0.0025 * 0.02,
    ),
    "cone on a disc": (
        revolved([((0.0, 0.0), (0.2, 0.0), (0.2, 0.1), (0.0, 0.1)), ((0.0, 0.1), (0.1, 0.1), (0.0, 0.4))], axis="y"),
        CIRCLE * (0.04 * 0.1 + 0.01 * 0.3 / 3.0),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_volume_is_that_of_the_formula(name: str) -> None:
    shape, expected = SHAPES[name]
    assert shape.volume.volume_m3 == pytest.approx(expected, rel=1e-6)  # profiles are rounded to 10 nm


WHOLE = [name for name in SHAPES if name != "plate with holes"]


def inside_and_covered(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of a grid over the shape, whether they are inside its solid, and whether inside a convex piece."""
    points, _ = shape.surface
    axes = [np.linspace(low, high, 11) + 1e-4 for low, high in zip(points.min(axis=0), points.max(axis=0), strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = np.array([bool((shape.solid ^ box(p - 1e-6, p + 1e-6).solid).volume() > 4e-18) for p in grid])
    assert inside.sum() > 50
    return grid, inside, np.any([contains(*convex_hull(surface(p)[0]), grid) for p in shape.convex], axis=0)


@pytest.mark.parametrize("name", WHOLE)
def test_convex_pieces_cover_the_solid_and_little_else(name: str) -> None:
    """What they hold more are the chords of sectors."""
    _, inside, covered = inside_and_covered(SHAPES[name][0])
    assert not (inside & ~covered).any()
    assert (covered & ~inside).sum() <= 0.15 * inside.sum()


def test_convex_pieces_of_a_plate_leave_a_square_around_each_hole() -> None:
    grid, inside, covered = inside_and_covered(SHAPES["plate with holes"][0])
    assert not (covered & ~inside).any()
    in_square = np.any([(np.abs(grid[:, :2] - [0.0, y]) < 0.0501).all(axis=1) for y in (-0.1, 0.1)], axis=0)
    assert not (inside & ~covered & ~in_square).any()


@pytest.mark.parametrize("name", WHOLE)
def test_pieces_do_not_overlap(name: str) -> None:
    shape, expected = SHAPES[name]
    total = sum(volume(*convex_hull(surface(piece)[0])) for piece in shape.convex)
    assert total == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", SHAPES)
def test_pieces_follow_a_shape_that_is_moved_and_turned(name: str) -> None:
    shape = SHAPES[name][0].moved((0.1, 0.2, 0.3)).turned(AXES["y"], 0.7, (0.5, 0.0, 0.0))
    points, _ = shape.surface
    pieces = np.concatenate([surface(piece)[0] for piece in shape.convex])
    for direction in (*AXES.values(), np.array([0.5, 0.5, 0.7])):
        assert (pieces @ direction).max() == pytest.approx((points @ direction).max(), abs=2e-3)


def test_a_union_of_touching_boxes_is_one_body() -> None:
    whole = union([box((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), box((0.1, 0.0, 0.0), (0.2, 0.1, 0.1))])
    assert whole.volume.volume_m3 == pytest.approx(0.002)
    assert len(whole.solid.decompose()) == 1
    assert len(whole.convex) == 2


def test_a_box_without_inside_is_refused() -> None:
    with pytest.raises(ValueError, match="no inside"):
        box((0.0, 0.0, 0.0), (0.1, -0.1, 0.1))
