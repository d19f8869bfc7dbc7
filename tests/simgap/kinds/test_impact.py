"""Impacts: the law against mechanics, and effects hidden in events that a contact of springs made.

The truth integrates a hysteretic spring (Walton and Braun, J. Rheol. 30, 1986) with smooth friction through each
contact; it shares nothing with the closed-form law that explains it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from schemas.measurement import MeasurementSpec
from simgap.find_gap import find_effects
from simgap.kinds.impact.law import mobility, velocity_after
from simgap.kinds.impact.problem import ImpactProblem
from simgap.recording.read import Measurement
from simgap.recording.recording import Impacts
from simgap.recording.train_test_split import split_trials

MASS_KG, INERTIA, MU, BOUNCE = 0.05, 2e-5, 0.3, 0.5
ARMS_M = (0.015, 0.03)  # largest along the surface, over it
NOISE = np.array([0.01, 0.01, 0.3])
SPRING_NPM, STEP_S, STEPS, SMOOTH_MPS = 4e5, 4e-6, 800, 0.015


@dataclass(frozen=True)
class Truth:
    friction: float = MU
    restitution: float = BOUNCE
    inertia_factor: float = 1.0
    com_m: tuple[float, float] = (0.0, 0.0)


def spring_contact(truth: Truth, before: np.ndarray, arms: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(n, 3) velocity of the tracked point after contact at `arms` (n, 2) from it, under the body."""
    c, s = np.cos(angle), np.sin(angle)
    com = np.stack([c * truth.com_m[0] - s * truth.com_m[1], s * truth.com_m[0] + c * truth.com_m[1]], axis=1)
    r = arms - com
    v = before[:, :2] + before[:, 2:] * np.stack([-com[:, 1], com[:, 0]], axis=1)
    w, depth, deepest = before[:, 2].copy(), np.zeros(len(r)), np.zeros(len(r))
    for _ in range(STEPS):
        slip, sinking = v[:, 0] - w * r[:, 1], -(v[:, 1] + w * r[:, 0])
        depth = depth + STEP_S * sinking
        deepest = np.maximum(deepest, depth)
        stiff = SPRING_NPM / truth.restitution**2
        back = SPRING_NPM * deepest - stiff * (deepest - depth)
        normal = np.maximum(np.where(depth >= deepest, SPRING_NPM * depth, back), 0.0)
        along = -truth.friction * normal * slip / np.hypot(slip, SMOOTH_MPS)
        v = v + STEP_S / MASS_KG * np.stack([along, normal], axis=1)
        w = w + STEP_S / (truth.inertia_factor * INERTIA) * (r[:, 0] * normal - r[:, 1] * along)
    origin = v - w[:, None] * np.stack([-com[:, 1], com[:, 0]], axis=1)
    return np.column_stack([origin, w])


def events(truth: Truth, seed: int, n: int = 120) -> Impacts:
    rng = np.random.default_rng(seed)
    before = np.column_stack([rng.uniform(-1.0, 1.0, n), rng.uniform(-3.0, -1.5, n), rng.uniform(-8.0, 8.0, n)])
    arms = np.column_stack([rng.uniform(-1.0, 1.0, n) * ARMS_M[0], -ARMS_M[1] * rng.uniform(0.7, 1.0, n)])
    angle = rng.uniform(-np.pi, np.pi, n)
    after = spring_contact(truth, before, arms, angle) + NOISE * rng.normal(size=(n, 3))
    zero, one = np.zeros(n), np.ones(n)
    pose = np.column_stack([zero, zero, angle])
    return Impacts(
        ids=tuple(map(str, range(n))),
        pose_before=pose,
        velocity_before=before + NOISE * rng.normal(size=(n, 3)),
        pose_after=pose,
        velocity_after=after,
        normal=np.column_stack([zero, one, arms[:, 0]]),
        tangent=np.column_stack([one, zero, -arms[:, 1]]),
    )


def problem_of(impacts: Impacts, tmp_path) -> ImpactProblem:
    spec = MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "events",
            "kind": "impact",
            "subject": {
                "mass_kg": MASS_KG,
                "inertia_kgm2": [INERTIA] * 3,
                "contact": {"friction": MU, "restitution": BOUNCE},
            },
        }
    )
    measurement = Measurement(spec, (), tmp_path, "", impacts=impacts)
    return ImpactProblem(measurement, split_trials(spec, impacts.ids))


def named(problem: ImpactProblem) -> dict[str, dict[str, float]]:
    verdict = find_effects(problem, problem.trials, measurement="", horizon_s=0.0, quick=True).report.verdict
    return {e.name: {n: p.value for n, p in e.parameters.items()} for e in verdict.effects if e.confidence >= 0.8}


def test_the_law_keeps_momentum_friction_cone_and_energy():
    rng = np.random.default_rng(0)
    n = 500
    arms = rng.uniform(-0.05, 0.05, (n, 2))
    N = np.column_stack([np.zeros(n), np.ones(n), arms[:, 0]])
    T = np.column_stack([np.ones(n), np.zeros(n), -arms[:, 1]])
    before = np.column_stack([rng.normal(size=(n, 2)), 20.0 * rng.normal(size=n)])
    W = mobility(0.2, 3e-4, np.zeros((n, 2)))
    M = np.diag([0.2, 0.2, 3e-4])
    after = velocity_after(before, N, T, W, 0.4, 0.6)
    approach, part = np.einsum("ni,ni->n", N, before), np.einsum("ni,ni->n", N, after)
    hit = approach < 0.0
    np.testing.assert_array_equal(after[~hit], before[~hit])
    assert (part[hit] >= -1e-9).all()
    impulse = (after - before) @ M
    assert (np.abs(impulse[:, 0]) <= 0.4 * impulse[:, 1] + 1e-12).all()
    np.testing.assert_allclose(impulse[:, 2], arms[:, 0] * impulse[:, 1] - arms[:, 1] * impulse[:, 0], atol=1e-12)
    energy = [np.einsum("ni,ij,nj->n", v, M, v) for v in (before, after)]
    assert (energy[1] <= energy[0] + 1e-9).all()


def test_a_central_impact_is_newtons():
    one = np.array([[0.0, 1.0, 0.0]])
    along = np.array([[1.0, 0.0, 0.02]])
    after = velocity_after(np.array([[0.0, -2.0, 0.0]]), one, along, mobility(1.0, 1.0, np.zeros((1, 2))), 0.5, 0.3)
    np.testing.assert_allclose(after, [[0.0, 0.6, 0.0]], atol=1e-12)


def test_mobility_about_another_point_is_that_of_the_moved_mass_centre():
    c = np.array([[0.02, -0.01]])
    shift = np.array([[1.0, 0.0, -c[0, 1]], [0.0, 1.0, c[0, 0]], [0.0, 0.0, 1.0]])  # velocity of c from the origin's
    M = shift.T @ np.diag([0.3, 0.3, 2e-4]) @ shift
    np.testing.assert_allclose(mobility(0.3, 2e-4, c)[0] @ M, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    ("truth", "name", "parameter", "value"),
    [
        (Truth(friction=0.12), "contact.friction", "mu", 0.12),
        (Truth(restitution=0.75), "contact.restitution", "restitution", 0.75),
        (Truth(inertia_factor=1.6), "body.inertia", "factor", 1.6),
        (Truth(com_m=(0.004, -0.003)), "body.com_offset", "x_m", 0.004),
    ],
)
def test_a_hidden_effect_is_named(truth: Truth, name: str, parameter: str, value: float, tmp_path):
    found = named(problem_of(events(truth, 1), tmp_path))
    assert list(found) == [name]
    assert found[name][parameter] == pytest.approx(value, rel=0.12)


@pytest.mark.parametrize("seed", range(2))
def test_controls_stay_without_a_name(seed: int, tmp_path):
    assert named(problem_of(events(Truth(friction=0.305, restitution=0.49), 10 + seed), tmp_path)) == {}


def test_a_tangent_jacobian_of_the_other_sense_is_found_and_turned(tmp_path):
    right = events(Truth(), 3)
    mirrored = replace(right, tangent=right.tangent * [1.0, 1.0, -1.0])
    assert problem_of(right, tmp_path).convention_check.status == "ok"
    problem = problem_of(mirrored, tmp_path)
    assert problem.convention_check.status == "fixed"
    assert "tangent Jacobian" in problem.convention_check.evidence
    np.testing.assert_array_equal(problem.events.tangent, right.tangent)
    assert named(problem) == {}


def test_equal_input_gives_equal_reports(tmp_path):
    one, two = (
        find_effects(p, p.trials, measurement="", horizon_s=0.0, quick=True).report
        for p in (problem_of(events(Truth(friction=0.1), 5, 24), tmp_path) for _ in range(2))
    )
    assert one == two
