"""Jointed free bodies in PyBullet: conservation laws, a rigid twin, and MuJoCo as an independent judge."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geom.mass.inertia import combine, moved
from geom.pose import angle_between
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, MassProperties
from sim.bullet.body import BulletBodyRollout
from sim.bullet.linkage import BulletLinkageRollout
from sim.dynamics.body_rollout import BodyModel, BodyWindows
from sim.dynamics.linkage_rollout import LinkageModel, LinkageMotion, LinkageWindows, link_poses
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import Link

FINE_S = 1.0 / 8000.0
T_S = np.linspace(0.0, 0.25, 11)
Q0, QD0 = np.array([[0.7, -0.3]]), np.array([[5.0, -4.0]])


def inertia(a: float, b: float, c: float) -> FloatArray:
    R = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_matrix()
    return R @ np.diag([a, b, c]) @ R.T


def pose(p: tuple[float, float, float], turn: tuple[float, float, float]) -> FloatArray:
    X = np.eye(4)
    X[:3, 3], X[:3, :3] = p, Rotation.from_rotvec(turn).as_matrix()
    return X


def linkage(friction: float = 0.0, damping: float = 0.0, support: bool = False) -> LinkageModel:
    """A base and two links in a chain; nothing is centred, aligned or equal."""
    box = (CollisionShape("box", (0.1, 0.05, 0.04), np.eye(4)),)
    base = BodyModel(
        shapes=box,
        mass_kg=0.5,
        com_B=np.array([0.01, -0.02, 0.005]),
        inertia_B=inertia(8e-4, 1e-3, 6e-4),
        gravity_W=np.array([0.0, 0.0, -9.81]),
        has_support=support,
    )
    y = np.array([0.0, 1.0, 0.0])
    axis = np.array([0.6, 0.0, 0.8])
    tree = (
        Link(
            "elbow",
            -1,
            False,
            y,
            pose((-0.03, 0.06, 0.01), (0.2, 0.1, -0.3)),
            0.3,
            np.array([0.03, 0, 0.01]),
            inertia(4e-4, 5e-4, 3e-4),
        ),
        Link(
            "wrist",
            0,
            False,
            axis,
            pose((0.08, 0.01, 0.0), (0.0, 0.4, 0.1)),
            0.2,
            np.array([0.02, 0.01, 0]),
            inertia(2e-4, 3e-4, 2.5e-4),
        ),
    )
    two = np.ones(2)
    joints = MechanismModel(tree, base.gravity_W, friction * two, damping * two)
    return LinkageModel(base, joints, (box, box), ("base", "upper", "lower"))


def start(t_s: FloatArray = T_S) -> LinkageWindows:
    quat = np.roll(Rotation.from_rotvec([0.4, -0.7, 0.2]).as_quat(), 1)
    base = BodyWindows(
        t_s[None], np.array([[0.1, 0.2, 1.0]]), quat[None], np.array([[1.0, -0.5, 2.0]]), np.array([[3.0, -6.0, 2.0]])
    )
    return LinkageWindows(base, Q0, QD0)


def momenta(model: LinkageModel, motion: LinkageMotion, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mass centre (k, 3) and angular momentum about it (k, 3) from poses alone, by central differences."""
    h = float(t_s[1] - t_s[0])
    R_WB = Rotation.from_quat(np.roll(motion.base.quat_wxyz[0], -1, axis=1)).as_matrix()
    masses = [model.base.mass_kg, *(link.mass_kg for link in model.joints.tree)]
    coms = [model.base.com_B, *(link.com_J for link in model.joints.tree)]
    tensors = [model.base.inertia_B, *(link.inertia_J for link in model.joints.tree)]
    at, R = [], []
    for (R_BL, p_BL), com in zip(link_poses(model, motion.q[0]), coms, strict=True):
        at.append(motion.base.p[0] + np.einsum("kab,kb->ka", R_WB, p_BL + R_BL @ com))
        R.append(R_WB @ R_BL)
    centre = np.sum([m * p for m, p in zip(masses, at, strict=True)], axis=0) / sum(masses)
    total = np.zeros((len(t_s) - 2, 3))
    for m, p, turned, tensor in zip(masses, at, R, tensors, strict=True):
        r = (p - centre)[1:-1]
        v = np.gradient(p - centre, h, axis=0)[1:-1]
        w = Rotation.from_matrix(turned[2:] @ turned[:-2].transpose(0, 2, 1)).as_rotvec() / (2.0 * h)
        total += m * np.cross(r, v) + np.einsum("kab,bc,kdc,kd->ka", turned[1:-1], tensor, turned[1:-1], w)
    return centre, total


@pytest.mark.parametrize("damping", [0.0, 0.002])
def test_what_joints_do_inside_moves_neither_mass_centre_nor_angular_momentum(damping: float) -> None:
    model, t_s = linkage(damping=damping), np.linspace(0.0, 0.25, 251)
    with BulletLinkageRollout(FINE_S) as engine:
        motion = engine.rollout(model, start(t_s))
    centre, total = momenta(model, motion, t_s)
    fall = np.diff(centre, 2, axis=0) / (t_s[1] - t_s[0]) ** 2
    np.testing.assert_allclose(fall.mean(axis=0), [0.0, 0.0, -9.81], atol=1e-3)
    assert np.linalg.norm(total - total[0], axis=1).max() < 1e-3 * np.linalg.norm(total[0])


def test_held_joints_make_one_rigid_body() -> None:
    model = linkage(friction=1e3)
    windows = replace(start(), qd0=np.zeros((1, 2)))
    with BulletLinkageRollout(FINE_S) as engine:
        motion = engine.rollout(model, windows)
    parts = [MassProperties(model.base.mass_kg, model.base.com_B, model.base.inertia_B)]
    for link, (R, p) in zip(model.joints.tree, link_poses(model, Q0)[1:], strict=True):
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = R[0], p[0]
        parts.append(moved(MassProperties(link.mass_kg, link.com_J, link.inertia_J), X))
    whole = combine(parts)
    numbers = {"mass_kg": whole.mass_kg, "com_B": whole.centre_of_mass_m, "inertia_B": whole.inertia_kgm2}
    body = replace(model.base, **numbers)
    with BulletBodyRollout(FINE_S) as rigid:
        expected = rigid.rollout(body, windows.base)
    np.testing.assert_allclose(motion.q[0], np.repeat(Q0, len(T_S), axis=0), atol=1e-4)
    np.testing.assert_allclose(motion.base.p, expected.p, atol=1e-4)
    assert angle_between(motion.base.quat_wxyz, expected.quat_wxyz).max() < 1e-3


def mjcf(model: LinkageModel) -> str:
    def inertial(mass: float, com: FloatArray, tensor: FloatArray) -> str:
        full = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        return f'<inertial mass="{mass}" pos="{text(com)}" fullinertia="{text(full)}"/>'

    def text(values: object) -> str:
        return " ".join(repr(float(v)) for v in np.ravel(np.asarray(values)))

    inner = ""
    for j in (1, 0):
        link = model.joints.tree[j]
        quat = np.roll(Rotation.from_matrix(link.X_PJ[:3, :3]).as_quat(), 1)
        joint = f'<joint type="hinge" axis="{text(link.axis_J)}" damping="{model.joints.damping[j]}"/>'
        own = inertial(link.mass_kg, link.com_J, link.inertia_J)
        inner = f'<body pos="{text(link.X_PJ[:3, 3])}" quat="{text(quat)}">{joint}{own}{inner}</body>'
    base = inertial(model.base.mass_kg, model.base.com_B, model.base.inertia_B)
    option = '<option timestep="0.0001" integrator="RK4"/><compiler angle="radian"/>'
    return f"<mujoco>{option}<worldbody><body><freejoint/>{base}{inner}</body></worldbody></mujoco>"


@pytest.mark.parametrize("damping", [0.0, 0.003])
def test_flies_as_mujoco_says(damping: float) -> None:
    model, windows = linkage(damping=damping), start()
    with BulletLinkageRollout(FINE_S / 4.0) as engine:
        motion = engine.rollout(model, windows)
    m = mujoco.MjModel.from_xml_string(mjcf(model))
    d = mujoco.MjData(m)
    d.qpos[:] = [*windows.base.p[0], *windows.base.quat_wxyz[0], *Q0[0]]
    d.qvel[:] = [*windows.base.v_W[0], *windows.base.w_B[0], *QD0[0]]
    while d.time < T_S[-1] - 1e-9:
        mujoco.mj_step(m, d)
    np.testing.assert_allclose(motion.q[0, -1], d.qpos[7:], atol=5e-4)
    np.testing.assert_allclose(motion.base.p[0, -1], d.qpos[:3], atol=2e-5)
    assert angle_between(motion.base.quat_wxyz[0, -1], d.qpos[3:7]) < 5e-4


def test_windows_do_not_know_each_other() -> None:
    model = linkage(support=True)
    base = start().base
    low = replace(base, p=np.array([[0.0, 0.0, 0.05]]))
    with BulletLinkageRollout() as engine:
        alone = engine.rollout(model, LinkageWindows(low, Q0, QD0))
        pair = BodyWindows(*(np.concatenate([getattr(base, n), getattr(low, n)]) for n in vars(base)))
        both = engine.rollout(model, LinkageWindows(pair, np.repeat(Q0, 2, axis=0), np.repeat(QD0, 2, axis=0)))
    np.testing.assert_array_equal(both.base.p[1], alone.base.p[0])
    np.testing.assert_array_equal(both.q[1], alone.q[0])
