"""Loose probes on a loose body in PyBullet: the law of the lever, walls that stop, and nothing that carries over."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geom.pose import pose
from schemas.physics import CollisionShape, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.loading import LoadOutcome, LoadTask, LooseProbe
from tests.support.sample_bodies import box, boxes, contact

G = 9.81
# A foot of 0.1 m under a top of 0.5 m: a load at x tips it when load * (x - 0.05) > mass * 0.05.
TABLE = boxes([((0.1, 0.1, 0.4), (0.0, 0.0, 0.2)), ((0.5, 0.5, 0.02), (0.0, 0.0, 0.41))])
TOP_M = 0.42


def cube(edge: float, at: tuple[float, float, float]) -> CollisionShape:
    return CollisionShape("box", (edge, edge, edge), pose(None, at))


def ball(radius: float, at: tuple[float, float, float]) -> CollisionShape:
    return CollisionShape("sphere", (radius,), pose(None, at))


def load(body: RigidBody, *probes: LooseProbe, seconds: float = 1.0, **changes) -> LoadOutcome:
    with BulletSimulator() as simulator:
        return simulator.load(body, LoadTask(np.eye(4), probes, seconds, **changes))


@pytest.mark.parametrize("share", [0.85, 1.15])
def test_a_load_tips_a_table_by_the_law_of_the_lever(share: float) -> None:
    limit_kg = TABLE.mass.mass_kg * 0.05 / 0.15
    outcome = load(TABLE, LooseProbe(cube(0.04, (0.2, 0.0, TOP_M + 0.02)), share * limit_kg))
    assert (outcome.turn_rad() > math.radians(10.0)) == (share > 1.0)


@pytest.mark.parametrize("edge_m", [0.01, 0.1, 8.0])
def test_a_stack_stays_at_every_size(edge_m: float) -> None:
    """The smallest body is simulated as a larger model, the largest as a smaller one."""
    body = box((edge_m, edge_m, edge_m))
    heights = [edge_m * (1.0 + 0.3 * (level + 0.5)) for level in range(3)]
    probes = [LooseProbe(cube(0.3 * edge_m, (0.0, 0.0, z)), 0.01 * body.mass.mass_kg) for z in heights]
    outcome = load(body, *probes, seconds=8.0 * math.sqrt(edge_m / G))
    assert np.abs(outcome.X_WP[-1, :, :3, 3] - outcome.X_WP[0, :, :3, 3]).max() < 0.01 * edge_m
    assert outcome.turn_rad() < 0.01


def test_probes_fall_by_the_law_and_with_the_speed_that_they_are_given() -> None:
    probe = replace(LooseProbe(ball(0.01, (1.0, 0.0, 2.0)), 0.01), velocity_mps=(0.5, 0.0, -1.0))
    outcome = load(box((0.1, 0.1, 0.1)), probe, seconds=0.3)
    t = outcome.times_s
    assert t[-1] == pytest.approx(0.3, abs=0.005)
    # The engine takes off a fifth of the speed in a second, as air does of light things.
    assert outcome.X_WP[:, 0, 0, 3] == pytest.approx(1.0 + 0.5 * t, abs=0.01)
    assert outcome.X_WP[:, 0, 2, 3] == pytest.approx(2.0 - t - 0.5 * G * t**2, abs=0.03)


def test_over_a_fixed_body_each_probe_is_alone_and_there_is_no_ground() -> None:
    heavy = box((0.1, 0.1, 0.1))
    twice = [LooseProbe(ball(0.02, (0.0, 0.0, 0.12)), 100.0) for _ in range(2)]
    beside = LooseProbe(ball(0.02, (0.5, 0.0, 0.12)), 0.1)
    outcome = load(heavy, *twice, beside, seconds=1.0, is_fixed=True)
    assert outcome.X_WP[-1, :2, 2, 3] == pytest.approx([0.12, 0.12], abs=1e-3)
    assert outcome.X_WP[-1, 2, 2, 3] < -2.0
    assert np.array_equal(outcome.X_WA[-1], np.eye(4))


def test_loose_probes_touch_one_another_the_ground_and_the_body() -> None:
    upon = [LooseProbe(cube(0.04, (0.0, 0.0, 0.12 + 0.04 * k)), 0.05) for k in range(2)]
    beside = LooseProbe(cube(0.04, (0.5, 0.0, 0.02)), 0.05)
    outcome = load(box((0.1, 0.1, 0.1)), *upon, beside)
    assert outcome.X_WP[-1, :, 2, 3] == pytest.approx([0.12, 0.16, 0.02], abs=1e-3)


@pytest.mark.parametrize(("slope_deg", "slides"), [(20.0, False), (33.0, True)])
def test_on_a_slope_a_load_slides_when_the_friction_of_the_pair_is_too_little(slope_deg: float, slides: bool) -> None:
    """Both have 0.5, which holds up to 26.6 degrees."""
    slope = math.radians(slope_deg)
    probe = LooseProbe(cube(0.03, (0.0, 0.0, 0.035)), 0.01)
    gravity = (G * math.sin(slope), 0.0, -G * math.cos(slope))
    outcome = load(box((0.4, 0.4, 0.02)), probe, seconds=0.5, gravity_mps2=gravity)
    assert (outcome.X_WA[-1, 0, 3] > 0.03) == slides
    assert (outcome.X_WP[-1, 0, 0, 3] > 0.03) == slides


def test_the_friction_of_the_body_is_combined_by_its_rule() -> None:
    slope = math.radians(20.0)
    gravity = (G * math.sin(slope), 0.0, -G * math.cos(slope))
    slippery = box((0.4, 0.4, 0.02), contact(0.1, combine="minimum"))
    assert load(slippery, seconds=0.5, gravity_mps2=gravity).X_WA[-1, 0, 3] > 0.2


def test_equal_tasks_end_equal() -> None:
    probe = LooseProbe(ball(0.02, (0.03, 0.01, TOP_M + 0.1)), 0.5)
    first, second = load(TABLE, probe), load(TABLE, probe)
    assert np.array_equal(first.X_WA, second.X_WA)
    assert np.array_equal(first.X_WP, second.X_WP)


def test_without_probes_a_body_stands() -> None:
    outcome = load(box((0.1, 0.1, 0.1)))
    assert outcome.X_WP.shape[1:] == (0, 4, 4)
    assert outcome.turn_rad() < 1e-3
    assert outcome.finite


@pytest.mark.parametrize(("share", "comes_through"), [(0.9, False), (1.3, True)])
def test_a_ball_goes_through_a_wall_when_a_step_takes_it_past_its_middle(share: float, comes_through: bool) -> None:
    """A step of its radius and half of the wall; starts spread over a step, for it depends on where the steps fall."""
    radius, wall, step_s, starts = 0.005, 0.002, 1.0 / 240.0, 24
    speed = share * (radius + 0.5 * wall) / step_s
    heights = [0.5 * wall + radius + 0.02 + k / starts * speed * step_s for k in range(starts)]
    balls = [LooseProbe(ball(radius, (0.02, 0.01, z)), 0.01, (0.0, 0.0, -speed)) for z in heights]
    plate = box((0.2, 0.2, wall))
    lowered = replace(plate, shapes=tuple(replace(s, X_AS=np.eye(4)) for s in plate.shapes))
    outcome = load(lowered, *balls, seconds=0.2, is_fixed=True, step_s=step_s, gravity_mps2=(0.0, 0.0, -0.1))
    assert bool((outcome.X_WP[-1, :, 2, 3] < 0.0).any()) == comes_through
