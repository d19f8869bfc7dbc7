"""Pushes: quasi-static sliding against closed forms, and effects hidden in pushes over many points of support.

The truth knows no limit surface: it minimises the power that friction takes at each point of support (Peshkin and
Sanderson, IEEE J. Robotics and Automation 4(6), 1988) for a tip that does not slip on the body.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.measurement import MeasurementSpec
from simgap.find_gap import find_effects
from simgap.kinds.push.footprint import nearest
from simgap.kinds.push.problem import PushProblem
from simgap.kinds.push.sliding import simulate_pushes
from simgap.recording.read import Measurement
from simgap.recording.recording import Push
from simgap.recording.train_test_split import split_trials

SIZE_M, MASS_KG, MU, G = np.array([0.12, 0.08]), 1.2, 0.3, 9.81
PATH_M, STEPS = 0.02, 20
NOISE_M, NOISE_RAD, NOISE_N = 2e-4, 2e-3, 0.05
GOLDEN = 0.6180339887498949


def grid(n: int = 10) -> np.ndarray:
    """(n * n, 2) points spread evenly under the body."""
    at = (np.arange(n) + 0.5) / n - 0.5
    return np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2) * SIZE_M


@dataclass(frozen=True)
class Truth:
    friction: float = MU
    ratio: float = 1.0  # of friction along the body's x axis
    support: np.ndarray = field(default_factory=grid)


def power(truth: Truth, at: np.ndarray, u: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) friction's power over the weight, and (n, 2) force over it, for a contact `at` (n, 2) that moves with u."""
    arm = truth.support - at[:, None]
    v = u[:, None] + turn[:, None, None] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
    scale = np.array([truth.ratio, 1.0])
    size = np.linalg.norm(v * scale, axis=-1)
    pull = truth.friction * v * scale**2 / np.maximum(size, 1e-12)[..., None]
    return truth.friction * size.mean(axis=1), pull.mean(axis=1)


def least_power_turn(truth: Truth, at: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(n,) turn per step that takes least power, by golden section."""
    reach = np.linalg.norm(u, axis=1) / 0.005
    low, high = -reach, reach
    for _ in range(30):
        a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        left = power(truth, at, u, a)[0] < power(truth, at, u, b)[0]
        low, high = np.where(left, low, a), np.where(left, b, high)
    return 0.5 * (low + high)


def pushes(truth: Truth, seed: int, n: int = 30) -> tuple[Push, ...]:
    rng = np.random.default_rng(seed)
    side = rng.integers(0, 4, n)
    out = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])[side]
    along = np.stack([-out[:, 1], out[:, 0]], axis=1)
    half = 0.5 * SIZE_M
    at = out * half + along * half * rng.uniform(-0.8, 0.8, (n, 1))
    lean = rng.uniform(-0.4, 0.4, n)
    way = -out * np.cos(lean)[:, None] + along * np.sin(lean)[:, None]
    yaw0 = rng.uniform(-np.pi, np.pi, n)
    turn = Rotation.from_rotvec(np.outer(yaw0, [0.0, 0.0, 1.0])).as_matrix()[:, :2, :2]
    origin0 = rng.uniform(-0.1, 0.1, (n, 2))
    tip0 = origin0 + np.einsum("nij,nj->ni", turn, at)
    move = np.einsum("nij,nj->ni", turn, way) * PATH_M
    yaw, forces = yaw0.copy(), []
    for _ in range(STEPS):
        R = np.stack([np.stack([np.cos(yaw), -np.sin(yaw)], -1), np.stack([np.sin(yaw), np.cos(yaw)], -1)], -2)
        u = np.einsum("nji,nj->ni", R, move / STEPS)
        w = least_power_turn(truth, at, u)
        forces.append(MASS_KG * G * np.einsum("nij,nj->ni", R, power(truth, at, u, w)[1]))
        yaw = yaw + w
    R = np.stack([np.stack([np.cos(yaw), -np.sin(yaw)], -1), np.stack([np.sin(yaw), np.cos(yaw)], -1)], -2)
    origin = tip0 + move - np.einsum("nij,nj->ni", R, at)
    force = np.stack(forces, axis=1)
    t = np.linspace(0.0, 2.0, STEPS + 1)
    all_pushes = []
    for k in range(n):
        poses = [
            (np.array([*(p + NOISE_M * rng.normal(size=2)), 0.01]), quat(a + NOISE_RAD * rng.normal()))
            for p, a in ((origin0[k], yaw0[k]), (origin[k], yaw[k]))
        ]
        path = tip0[k] + np.outer(t / t[-1], move[k])
        all_pushes.append(
            Push(
                id=f"p{k}",
                before_p=poses[0][0],
                before_quat_wxyz=poses[0][1],
                after_p=poses[1][0],
                after_quat_wxyz=poses[1][1],
                tip_t_s=t,
                tip_p=np.column_stack([path, np.full(len(t), 0.01)]),
                tip_quat_wxyz=np.full((len(t), 4), np.nan),
                force_t_s=t[1:],
                force=force[k] + NOISE_N * rng.normal(size=(STEPS, 2)),
            )
        )
    return tuple(all_pushes)


def quat(yaw: float) -> np.ndarray:
    return np.array([np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)])


def problem_of(pushes: tuple[Push, ...], tmp_path) -> PushProblem:
    subject = {
        "box": {"size_m": [*SIZE_M, 0.02]},
        "mass_kg": MASS_KG,
        "contact": {"friction": MU, "restitution": 0.0},
    }
    spec = MeasurementSpec.model_validate({"schema_version": 1, "name": "block", "kind": "push", "subject": subject})
    return PushProblem(Measurement(spec, (), tmp_path, "", pushes=pushes))


def verdict_of(problem: PushProblem):
    trials = split_trials(problem.measurement.spec, problem.trial_ids)
    return find_effects(problem, trials, measurement="", horizon_s=0.0, quick=True).report.verdict


def named(verdict) -> dict[str, dict[str, float]]:
    return {e.name: {n: p.value for n, p in e.parameters.items()} for e in verdict.effects if e.confidence >= 0.8}


def test_a_push_through_the_mass_centre_moves_straight_and_takes_the_whole_friction(tmp_path):
    model = problem_of(pushes(Truth(), 0, 4), tmp_path).declared
    model = replace(model, standoff_m=0.0)
    tips = np.stack([np.linspace(-0.06, -0.04, 41), np.zeros(41)], axis=1)[None]
    poses, forces = simulate_pushes(model, np.zeros((1, 3)), tips)
    np.testing.assert_allclose(poses[0, -1], [0.02, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(forces[0, -1], [MU * MASS_KG * G, 0.0], rtol=1e-9)


def test_the_world_may_be_turned(tmp_path):
    problem = problem_of(pushes(Truth(), 0, 6), tmp_path)
    whole = problem._joined(problem.trial_ids)
    plain, force = simulate_pushes(problem.declared, whole.before, whole.tips)
    R = np.array([[0.0, -1.0], [1.0, 0.0]])
    start = np.column_stack([whole.before[:, :2] @ R.T, whole.before[:, 2] + np.pi / 2.0])
    turned, turned_force = simulate_pushes(problem.declared, start, whole.tips @ R.T)
    np.testing.assert_allclose(turned[..., :2], plain[..., :2] @ R.T, atol=1e-12)
    np.testing.assert_allclose(turned_force, force @ R.T, atol=1e-9)


def test_the_nearest_place_of_an_outline():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    distance, place, normal = nearest(square, np.array([[0.5, -0.2], [0.5, 0.1], [2.0, 2.0]]))
    np.testing.assert_allclose(distance, [0.2, -0.1, np.sqrt(2.0)])
    np.testing.assert_allclose(place, [[0.5, 0.0], [0.5, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(normal, [[0.0, -1.0], [0.0, -1.0], [np.sqrt(0.5), np.sqrt(0.5)]])


@pytest.mark.parametrize(
    ("truth", "name", "parameter", "value"),
    [
        (Truth(ratio=1.8), "contact.anisotropic_friction", "ratio", 1.8),
        (Truth(support=grid() + np.array([0.012, 0.0])), "body.com_offset", "x_m", 0.012),
        (Truth(support=0.4 * grid()), "contact.spinning_friction", "lever_m", None),
    ],
)
def test_a_hidden_effect_is_named(truth: Truth, name: str, parameter: str, value: float | None, tmp_path):
    found = named(verdict_of(problem_of(pushes(truth, 1), tmp_path)))
    assert list(found) == [name]
    assert value is None or found[name][parameter] == pytest.approx(value, rel=0.15)


def test_friction_and_weight_of_a_pushed_body_cannot_be_told_apart(tmp_path):
    verdict = verdict_of(problem_of(pushes(Truth(friction=0.45), 2), tmp_path))
    assert verdict.status == "ambiguous"
    assert {"contact.friction", "body.mass"} <= set(verdict.ambiguous_groups[0].effects)
    assert named(verdict) == {}


def test_a_control_stays_without_a_name(tmp_path):
    assert named(verdict_of(problem_of(pushes(Truth(friction=0.305), 10), tmp_path))) == {}
