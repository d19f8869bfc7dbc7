"""The analytic simulator keeps the port's promises where it makes them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from geom.pose import matrix_of, pose
from schemas.physics import CollisionShape
from sim.fake import FakeSimulator
from sim.loading import LoadTask, LooseProbe
from sim.port import DropSettings, Simulator, rms_speeds, stillness_for, world_for
from tests.support.sample_bodies import box, hull, sphere

FAKE: Simulator = FakeSimulator()


def test_it_falls_along_a_parabola_and_then_stands() -> None:
    result = FAKE.drop(box((0.1, 0.1, 0.1)), pose(None, (1.0, 2.0, 0.5)), DropSettings(1.0))
    falling = result.times_s < np.sqrt(2 * 0.5 / 9.81)
    assert np.allclose(result.positions_m[falling, 2], 0.5 - 0.5 * 9.81 * result.times_s[falling] ** 2)
    assert np.allclose(result.positions_m[~falling], [1.0, 2.0, 0.0])
    assert result.touch_s(1e-9) == pytest.approx(np.sqrt(1 / 9.81), abs=1 / 240)
    assert result.penetration_m == pytest.approx(0.0, abs=1e-12)
    assert result.still_since_s(stillness_for(0.17)) == result.touch_s(1e-9)


def test_it_comes_to_rest_on_the_nearest_stable_face() -> None:
    leaning = Rotation.from_euler("x", 60, degrees=True).as_matrix()
    result = FAKE.drop(box((0.1, 0.1, 0.1)), pose(leaning, (0.0, 0.0, 1.0)), DropSettings(2.0))
    assert np.abs(matrix_of(result.quats_wxyz[-1])[2]) == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert result.heights_m[-1] == pytest.approx(0.0, abs=1e-12)
    assert result.contacts == 4


def test_it_does_not_stand_on_a_face_that_cannot_carry_it() -> None:
    """An oblique prism, whose mass centre lies beside its narrow ends."""
    points = trimesh.creation.box((0.1, 0.1, 0.4)).vertices.copy()
    points[:, 0] += 0.8 * points[:, 2]
    result = FAKE.drop(hull(trimesh.convex.convex_hull(points)), pose(None, (0.0, 0.0, 1.0)), DropSettings(2.0))
    assert abs(matrix_of(result.quats_wxyz[-1])[2, 2]) < 0.9


def test_a_body_without_faces_stays_as_it_touched_and_a_short_record_ends_in_the_air() -> None:
    ball = sphere(0.1)
    assert FAKE.drop(ball, pose(None, (0.0, 0.0, 1.0)), DropSettings(0.1)).contacts == 0
    assert FAKE.drop(ball, pose(None, (0.0, 0.0, 1.0)), DropSettings(1.0)).heights_m[-1] == pytest.approx(0.0, abs=1e-3)


def test_many_drops_are_the_single_ones() -> None:
    body = box((0.1, 0.2, 0.3))
    starts = [pose(None, (0.0, 0.0, z)) for z in (0.1, 0.2)]
    settings = DropSettings(0.5, world_for(0.37))
    for many, X_WA in zip(FAKE.drop_many(body, starts, settings), starts, strict=True):
        assert np.array_equal(many.positions_m, FAKE.drop(body, X_WA, settings).positions_m)


def test_rms_speed_is_that_of_the_kinetic_energy() -> None:
    body = box((0.1, 0.2, 0.3))
    turned = Rotation.from_euler("xyz", [0.3, 0.4, 0.5]).as_matrix()
    linear, angular = np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0])
    inertia_W = turned @ body.mass.inertia_kgm2 @ turned.T
    energy = 0.5 * body.mass.mass_kg * linear @ linear + 0.5 * angular @ inertia_W @ angular
    speed = rms_speeds(body.mass, turned[None], linear[None], angular[None])[0]
    assert speed == pytest.approx(np.sqrt(2 * energy / body.mass.mass_kg))


def test_loads_come_to_rest_on_a_body_that_does_not_move() -> None:
    probe = LooseProbe(CollisionShape("box", (0.02, 0.02, 0.02), pose(None, (0.0, 0.0, 0.2))), 0.1)
    outcome = FAKE.load(box((0.1, 0.1, 0.1)), LoadTask(pose(None, (0.0, 0.0, 0.03)), (probe,), 1.0))
    assert outcome.X_WP[-1, 0, :3, 3] == pytest.approx([0.0, 0.0, 0.14])
    assert outcome.probes_in_body()[-1, 0, :3, 3] == pytest.approx([0.0, 0.0, 0.11])
    assert outcome.turn_rad() == 0.0
