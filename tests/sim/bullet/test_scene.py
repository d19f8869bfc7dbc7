"""Settling of scenes: supported bodies stay, others fall; the result depends on nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from geom.mass.inertia import moved, of_box
from geom.pose import pose
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, Contact, RigidBody
from sim.bullet.scene import settle_scene
from sim.port import PlacedBody

CONTACT = Contact(static_friction=0.6, dynamic_friction=0.5, restitution=0.0)


def box(x: float, y: float, z: float, at: tuple[float, float, float], moves: bool = True) -> PlacedBody:
    """A box whose frame is at the bottom centre."""
    up = pose(None, (0.0, 0.0, z / 2.0))
    body = RigidBody("box", (CollisionShape("box", (x, y, z), up),), moved(of_box((x, y, z), 500.0), up), CONTACT)
    return PlacedBody(body, pose(None, at), moves)


TABLE = box(1.0, 0.6, 0.04, (0.0, 0.0, 0.0), moves=False)


def shifts_m(things: list[PlacedBody], duration_s: float = 1.0) -> np.ndarray:
    return settle_scene(things, duration_s)[:, :3, 3] - np.array([thing.X_WA[:3, 3] for thing in things])


@pytest.mark.parametrize("edge_m", [0.01, 0.05, 0.3])
def test_a_stack_of_three_stays_at_any_size(edge_m: float):
    stack = [box(edge_m, edge_m, edge_m, (0.1, 0.0, 0.04 + level * edge_m)) for level in range(3)]
    assert np.linalg.norm(shifts_m([TABLE, *stack]), axis=1).max() < 0.001


def test_what_hangs_over_the_edge_falls_and_its_neighbour_stays():
    over, safe = box(0.1, 0.1, 0.05, (0.56, 0.0, 0.04)), box(0.1, 0.1, 0.05, (0.0, 0.0, 0.04))
    shifts = shifts_m([TABLE, over, safe])
    assert shifts[1, 2] < -0.05
    assert np.linalg.norm(shifts[2]) < 0.001


def test_free_fall_is_that_of_galilei():
    fallen_m = -shifts_m([TABLE, box(0.1, 0.1, 0.1, (2.0, 0.0, 1.0))], 0.2)[1, 2]
    assert fallen_m == pytest.approx(0.5 * GRAVITY_MPS2 * 0.2**2, rel=0.02)


def test_equal_calls_equal_answers():
    things = [TABLE, box(0.1, 0.1, 0.05, (0.56, 0.0, 0.04)), box(0.1, 0.1, 0.05, (0.0, 0.0, 0.05))]
    np.testing.assert_array_equal(settle_scene(things, 0.5), settle_scene(things, 0.5))
