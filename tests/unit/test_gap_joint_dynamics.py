"""The closed form of joints side by side against the general recursion."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim.joint_dynamics import SeparateJoints
from sim.tree import Link, inverse_dynamics


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_closed_form_is_the_recursion(seed):
    rng = np.random.default_rng(seed)
    tree = tuple(_link(rng, slides=bool(k % 2)) for k in range(3))
    gravity_W = 9.81 * rng.normal(size=3)
    q, qd, qdd = rng.normal(size=(3, 5, 3))
    effort, load = SeparateJoints.of(tree, gravity_W).needed(q, qd, qdd)
    np.testing.assert_allclose(effort, inverse_dynamics(tree, q, qd, qdd, gravity_W)[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(load, inverse_dynamics(tree, q, qd, 0.0 * q, gravity_W)[1], rtol=1e-7, atol=1e-7)


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
