"""Direct estimates for a hinged body in flight, on motion simulated by MuJoCo, which shares no code with them."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from schemas.sim_gap.extension import Place
from sim.bullet.linkage import BulletLinkageRollout
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Series
from sim.dynamics.linkage_rollout import LinkageModel
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import Link
from sim.effects.library import effect
from simgap.kinds.free_body.bootstrap import simulated_motion
from simgap.kinds.free_body.direct_estimates import biases_of, estimate
from simgap.kinds.linkage.direct_estimates import routes_to
from simgap.kinds.linkage.tossed_body import LinkageSimulator
from simgap.problem import Candidate, DirectEstimate

RATE_HZ, ROWS, TOSSES = 150.0, 40, 24
NOISE_M, NOISE_RAD = 1e-4, 1e-3
BOX = (CollisionShape("box", (0.1, 0.05, 0.05), np.eye(4)),)


def hinge() -> LinkageModel:
    """Two boxes on a free hinge, as the owner believes them."""
    tensor = np.diag([1.5e-4, 3.8e-4, 3.8e-4])
    base = BodyModel(BOX, 0.37, np.zeros(3), tensor, has_support=False)
    X = np.eye(4)
    X[:3, 3] = [-0.035, 0.06, 0.0]
    link = Link("elbow", -1, False, np.array([0.0, 1.0, 0.0]), X, 0.37, np.array([0.035, 0.0, 0.0]), tensor)
    joints = MechanismModel((link,), base.gravity_W, np.zeros(1), np.zeros(1))
    return LinkageModel(base, joints, (BOX,), ("link_1", "link_2"))


def tosses(mass_kg: float = 0.37, inertia: float = 1.0, damping: float = 0.0, dry: float = 0.0) -> list[Series]:
    """Noisy flights of a hinge whose second link and joint are what the arguments say."""
    tensor = [inertia * v for v in (1.5e-4, 3.8e-4, 3.8e-4)]
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.0002" integrator="implicitfast"/><worldbody><body><freejoint/>
        <inertial mass="0.37" pos="0 0 0" diaginertia="1.5e-4 3.8e-4 3.8e-4"/>
        <body pos="-0.035 0.06 0"><joint type="hinge" axis="0 1 0" damping="{damping}" frictionloss="{dry}"/>
        <inertial mass="{mass_kg}" pos="0.035 0 0" diaginertia="{tensor[0]} {tensor[1]} {tensor[2]}"/></body>
        </body></worldbody></mujoco>"""
    )
    rng, out = np.random.default_rng(7), []
    for _ in range(TOSSES):
        data = mujoco.MjData(model)
        data.qpos[3:7] = np.roll(Rotation.random(rng=rng).as_quat(), 1)
        data.qpos[7] = rng.uniform(-2.0, 2.0)
        data.qvel[:] = [*rng.normal(0.0, 1.0, 3), *rng.normal(0.0, 6.0, 3), rng.normal(0.0, 12.0)]
        rows = []
        for row in range(ROWS):
            while data.time < row / RATE_HZ - 1e-9:
                mujoco.mj_step(model, data)
            rows.append(np.concatenate([data.qpos, data.qvel]))
        out.append(read(np.array(rows), rng))
    return out


def read(rows: FloatArray, rng: np.random.Generator) -> Series:
    """Readings with noise; rates as differences give them."""
    n = len(rows)
    p = rows[:, :3] + rng.normal(0.0, NOISE_M, (n, 3))
    R = Rotation.from_quat(np.roll(rows[:, 3:7], -1, axis=1)) * Rotation.from_rotvec(rng.normal(0, NOISE_RAD, (n, 3)))
    q = rows[:, 7:8] + rng.normal(0.0, NOISE_RAD, (n, 1))
    columns = {"p": p, "quat_wxyz": np.roll(R.as_quat(), 1, axis=1), "q": q}
    columns |= {"v_W": rows[:, 8:11], "w_B": rows[:, 11:14], "qd": np.gradient(q, 1.0 / RATE_HZ, axis=0)}
    return Series(np.arange(n) / RATE_HZ, columns)


def estimated(
    name: str, where: Place, null: dict[str, float], series: list[Series], believed: LinkageModel | None = None
) -> DirectEstimate:
    """The estimate, its error with what the estimator makes of a motion in which nothing is hidden."""
    candidate = Candidate(effect(name), where, null, null, dict.fromkeys(null, (-10.0, 10.0)))
    with BulletLinkageRollout() as engine:
        simulator = LinkageSimulator(believed or hinge(), engine)
        applied, routes = simulator.apply(()), routes_to(candidate)
        plain = [
            [simulator.toss(applied, simulated_motion(simulator, applied, s, finer)) for s in series]
            for finer in (1.0, 4.0)
        ]
    biases = biases_of(candidate, plain, routes)
    result = estimate(candidate, [simulator.toss(applied, s) for s in series], biases, routes)
    assert result is not None
    return result


LINK, JOINT = Place(body="link_2"), Place(joint="elbow")
CASES = [
    ("body.mass", LINK, "mass_kg", 0.37, {"mass_kg": 0.5}, 0.5),
    ("body.inertia", LINK, "factor", 1.0, {"inertia": 1.6}, 1.6),
    ("joint.viscous_friction", JOINT, "damping_Nms_per_rad", 0.0, {"damping": 2e-3}, 2e-3),
    ("joint.coulomb_friction", JOINT, "torque_Nm", 0.0, {"dry": 0.01}, 0.01),
]


@pytest.mark.parametrize(("name", "where", "number", "null", "hidden", "truth"), CASES, ids=[c[0] for c in CASES])
def test_flights_tell_a_hidden_number_within_its_error(
    name: str, where: Place, number: str, null: float, hidden: dict[str, float], truth: float
) -> None:
    found = estimated(name, where, {number: null}, tosses(**hidden))
    assert found.p_value < 0.01
    assert abs(found.values[number] - truth) < 3.0 * found.standard_errors[number]
    assert found.standard_errors[number] < 0.15 * abs(truth - null)


@pytest.mark.parametrize(("name", "where", "number", "null", "hidden", "truth"), CASES, ids=[c[0] for c in CASES])
def test_flights_of_what_is_declared_tell_nothing(
    name: str, where: Place, number: str, null: float, hidden: dict[str, float], truth: float
) -> None:
    found = estimated(name, where, {number: null}, tosses())
    assert found.p_value > 0.01
    assert abs(found.values[number] - null) < 0.1 * abs(truth - null)


def test_mass_centre_of_a_link() -> None:
    shifted = hinge()
    link = replace(shifted.joints.tree[0], com_J=np.array([0.03, 0.0, 0.0]))
    believed = replace(shifted, joints=replace(shifted.joints, tree=(link,)))
    found = estimated("body.com_offset", LINK, {"x_m": 0.03, "y_m": 0.0, "z_m": 0.0}, tosses(), believed)
    for name, truth in (("x_m", 0.035), ("y_m", 0.0), ("z_m", 0.0)):
        assert abs(found.values[name] - truth) < 4.0 * found.standard_errors[name]
    assert abs(found.values["x_m"] - 0.035) < 5e-4
