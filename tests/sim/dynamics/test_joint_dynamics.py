"""The closed forms of joints side by side and of planar chains against the general recursion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from sim.dynamics.joint_dynamics import CoupledJoints, PlanarChain, SeparateJoints, joint_dynamics
from sim.dynamics.mechanism import MechanismModel, Windows, rollout
from sim.dynamics.tree import Link, inverse_dynamics


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_closed_form_is_the_recursion(seed):
    rng = np.random.default_rng(seed)
    tree = tuple(_link(rng, slides=bool(k % 2)) for k in range(3))
    gravity_W = 9.81 * rng.normal(size=3)
    q, qd, qdd = rng.normal(size=(3, 5, 3))
    posture = SeparateJoints.of(tree, gravity_W).at(q)
    effort, load = posture.required_effort(qd, qdd), posture.load(qd)
    np.testing.assert_allclose(effort, inverse_dynamics(tree, q, qd, qdd, gravity_W)[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(load, inverse_dynamics(tree, q, qd, 0.0 * q, gravity_W)[1], rtol=1e-7, atol=1e-7)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_a_planar_chain_is_the_recursion(seed):
    rng = np.random.default_rng(seed)
    tree = tuple(_planar_link(rng, k) for k in range(3))
    gravity_W = 9.81 * rng.normal(size=3)
    q, qd, qdd = rng.normal(size=(3, 5, 3))
    h, damping = np.full((5, 1), 3e-3), rng.uniform(0.0, 1.0, 3)
    chain = joint_dynamics(tree, gravity_W)
    assert isinstance(chain, PlanarChain)
    planar, general = chain.at(q), CoupledJoints(tree, gravity_W).at(q)
    np.testing.assert_allclose(planar.required_effort(qd, qdd), general.required_effort(qd, qdd), rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(planar.load(qd), general.load(qd), rtol=1e-8, atol=1e-9)
    rates = planar.free_rates(qd, qdd, damping, h)
    momentum = np.einsum("wij,wj->wi", general.mass, qd) + h * qdd
    expected = np.linalg.solve(general.mass + h[:, :, None] * np.diag(damping), momentum[..., None])[..., 0]
    np.testing.assert_allclose(rates, expected, rtol=1e-8, atol=1e-9)
    largest = np.abs(rng.normal(size=(5, 3)))
    np.testing.assert_allclose(
        planar.with_dry_friction(rates, largest, damping, h),
        general.with_dry_friction(rates, largest, damping, h),
        rtol=1e-7,
        atol=1e-9,
    )


def _planar_link(rng: np.random.Generator, number: int) -> Link:
    link = _link(rng, slides=False)
    X_PJ = np.eye(4)
    X_PJ[:3, :3] = Rotation.from_rotvec([0.0, rng.normal(), 0.0]).as_matrix()
    X_PJ[:3, 3] = rng.normal(size=3) * [1.0, 0.0, 1.0]
    com_J = link.com_J * [1.0, 0.0, 1.0]
    axis_J = np.array([0.0, 1.0, 0.0])
    return replace(link, parent=number - 1, X_PJ=X_PJ, axis_J=axis_J, com_J=com_J, inertia_J=np.diag([1.0, 2.0, 2.5]))


def _link(rng: np.random.Generator, slides: bool) -> Link:
    X_PJ = np.eye(4)
    X_PJ[:3, :3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    X_PJ[:3, 3] = rng.normal(size=3)
    axis = rng.normal(size=3)
    spread = rng.normal(size=(3, 3))
    return Link(
        name="link",
        parent=-1,
        prismatic=slides,
        axis_J=axis / np.linalg.norm(axis),
        X_PJ=X_PJ,
        mass_kg=float(rng.uniform(0.1, 2.0)),
        com_J=rng.normal(size=3),
        inertia_J=spread @ spread.T + np.eye(3),
        armature=float(rng.uniform(0.0, 0.1)),
        gravity_factor=float(rng.uniform(0.5, 1.5)),
    )


@pytest.mark.parametrize("spans_s", [(0.01, 0.01), (0.001, 0.019)])
def test_whirling_links_are_followed_to_second_order(spans_s: tuple[float, float]):
    """Stamps may be uneven: what a step gained is that of its own length."""
    rng = np.random.default_rng(3)
    tree = tuple(_planar_link(rng, k) for k in range(2))
    model = MechanismModel(tree, np.array([0.0, 0.0, -9.81]), np.zeros(2), np.zeros(2))
    t_s = np.concatenate([[0.0], np.cumsum(np.tile(spans_s, 20))])
    windows = Windows(t_s[None], np.array([[0.3, 1.0]]), np.array([[4.0, -6.0]]))

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        q, qd = state[None, :2], state[None, 2:]
        posture = CoupledJoints(tree, model.gravity_W).at(q)
        return np.concatenate([state[2:], np.linalg.solve(posture.mass[0], -posture.bias(qd)[0])])

    exact = solve_ivp(rates, (0.0, t_s[-1]), [0.3, 1.0, 4.0, -6.0], t_eval=t_s, rtol=1e-10, atol=1e-10).y[:2].T
    errors = [np.abs(rollout(model, windows, finer=k)[0][0] - exact).max() for k in (4, 8, 16)]
    assert errors[0] > 3.5 * errors[1] > 3.5 * 3.5 * errors[2] > 0.0
