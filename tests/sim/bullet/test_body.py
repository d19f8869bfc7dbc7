"""Roll-outs of a free body in the engine: a window knows nothing of what was simulated before or beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from schemas.physics import CollisionShape
from sim.bullet.body import BulletBodyRollout
from sim.dynamics.body_rollout import BodyModel, BodyWindows

BOX = BodyModel(
    shapes=(CollisionShape("box", (0.1, 0.08, 0.06), np.eye(4)),),
    mass_kg=0.4,
    com_B=np.array([0.004, 0.0, -0.002]),
    inertia_B=np.diag([3e-4, 4e-4, 5e-4]),
)


def _windows(count: int, rows: int = 30) -> BodyWindows:
    rng = np.random.default_rng(3)
    quat = rng.normal(size=(count, 4))
    return BodyWindows(
        t_s=np.broadcast_to(np.arange(rows) / 148.0, (count, rows)),
        p=np.stack([np.zeros(count), np.zeros(count), rng.uniform(0.07, 0.2, count)], axis=1),
        quat_wxyz=quat / np.linalg.norm(quat, axis=1, keepdims=True),
        v_W=rng.normal(0.0, 1.0, (count, 3)),
        w_B=rng.normal(0.0, 5.0, (count, 3)),
    )


def _picked(windows: BodyWindows, at) -> BodyWindows:
    return BodyWindows(windows.t_s[at], windows.p[at], windows.quat_wxyz[at], windows.v_W[at], windows.w_B[at])


def test_windows_do_not_know_each_other():
    windows = _windows(8)
    with BulletBodyRollout() as engine:
        together = engine.rollout(BOX, windows)
        engine.rollout(replace(BOX, friction=0.1), windows)
        again = engine.rollout(BOX, windows)
        backwards = engine.rollout(BOX, _picked(windows, np.arange(8)[::-1]))
    np.testing.assert_array_equal(together.p, again.p)
    np.testing.assert_array_equal(together.quat_wxyz, backwards.quat_wxyz[::-1])


def test_changed_numbers_reach_the_engine():
    with BulletBodyRollout() as engine:
        rough = engine.rollout(BOX, _windows(4))
        smooth = engine.rollout(replace(BOX, friction=0.0), _windows(4))
    assert np.abs(rough.p - smooth.p).max() > 1e-3


def test_finer_steps_give_the_same_motion_until_contact_scatters_it():
    windows = _windows(12, 12)
    with BulletBodyRollout() as plain, BulletBodyRollout(1.0 / 3840.0) as fine:
        apart = np.linalg.norm(plain.rollout(BOX, windows).p - fine.rollout(BOX, windows).p, axis=2).max(axis=1)
    assert np.median(apart) < 1e-3


def test_a_start_inside_the_support_is_not_thrown_out_harder_by_finer_steps():
    windows = BodyWindows(
        t_s=np.arange(20)[None] / 148.0,
        p=np.array([[0.0, 0.0, 0.028]]),
        quat_wxyz=np.array([[1.0, 0.0, 0.0, 0.0]]),
        v_W=np.zeros((1, 3)),
        w_B=np.zeros((1, 3)),
    )
    tops = []
    for step_s in (1.0 / 240.0, 1.0 / 480.0, 1.0 / 3840.0):
        with BulletBodyRollout(step_s) as engine:
            tops.append(float(engine.rollout(replace(BOX, com_B=np.zeros(3)), windows).p[0, :, 2].max()))
    assert max(tops) < 0.0315
    assert tops[2] == pytest.approx(tops[0], abs=1e-3)


@pytest.mark.parametrize("step_s", [1.0 / 120.0, 1.0 / 480.0])
def test_a_fall_is_exact_at_any_step(step_s):
    """Positions and speeds of a parabola; what is left is single precision."""
    windows = _windows(3, 12)
    with BulletBodyRollout(step_s) as engine:
        motion = engine.rollout(replace(BOX, has_support=False, com_B=np.zeros(3)), windows)
    t = windows.t_s[..., None]
    parabola = windows.p[:, None] + t * windows.v_W[:, None] + 0.5 * t**2 * np.array([0.0, 0.0, -9.81])
    np.testing.assert_allclose(motion.p, parabola, atol=2e-5)
    np.testing.assert_allclose(motion.v_W, windows.v_W[:, None] + t * np.array([0.0, 0.0, -9.81]), atol=1e-4)
