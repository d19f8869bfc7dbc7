"""A box tossed onto a floor in MuJoCo: its contacts, drag and sensor are not those of the library.

Bounce comes from MuJoCo's damping ratio of contacts, friction from its elliptic cone, drag from forces set per step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

STEP_S, ROW_S, ROWS = 1e-3, 1.0 / 120.0, 90
Hidden = Mapping[str, float]


@dataclass(frozen=True)
class Box:
    """The box as its owner believes it: edges (3,) m, mass kg, friction with the floor."""

    size_m: np.ndarray
    mass: float
    mu: float

    @property
    def inertia(self) -> np.ndarray:
        """(3,) of an evenly filled box."""
        x, y, z = self.size_m**2
        return self.mass / 12.0 * np.array([y + z, x + z, x + y])


@dataclass(frozen=True)
class Recording:
    """What a tracker wrote: stamps (n,), p (n, 3), quaternions wxyz (n, 4), v world (n, 3), w body (n, 3)."""

    t_s: np.ndarray
    p: np.ndarray
    quat_wxyz: np.ndarray
    v: np.ndarray
    w: np.ndarray


def toss(
    box: Box,
    hidden: Hidden,
    rng: np.random.Generator,
    noise: float = 1.0,
    step_s: float = STEP_S,
    row_s: float = ROW_S,
) -> Recording:
    """One toss with hidden effects, read every `row_s` with noise, jitter and lost rows."""
    model = mujoco.MjModel.from_xml_string(_document(box, hidden, step_s))
    data = mujoco.MjData(model)
    start = Rotation.from_quat(rng.normal(size=4))
    data.qpos[:3] = [0.0, 0.0, rng.uniform(1.0, 2.2) * float(np.linalg.norm(box.size_m))]
    data.qpos[3:] = np.roll(start.as_quat(), 1)
    aim = rng.uniform(0.0, 2.0 * np.pi)
    speed = rng.uniform(0.3, 1.6)
    data.qvel[:3] = [speed * np.cos(aim), speed * np.sin(aim), rng.uniform(-0.6, 0.6)]
    data.qvel[3:] = rng.normal(0.0, 3.0, 3)
    pause = hidden.get("age_s", 0.0)
    true = np.empty((round((ROWS * ROW_S + 0.05) / step_s), 13))
    for k in range(len(true)):
        true[k] = [*data.qpos, *data.qvel]
        data.xfrc_applied[1, :3] = _force(hidden, data.qvel[:3], data.xmat[1].reshape(3, 3) @ data.qvel[3:])
        mujoco.mj_step(model, data)
    count = round(ROWS * ROW_S / row_s)
    stamps = 0.03 + np.arange(count) * row_s + rng.normal(0.0, 2e-4, count)
    rows = np.clip(np.round(stamps / step_s).astype(int), 0, len(true) - 2)
    late = np.clip(rows - round(pause / step_s), 0, len(true) - 2)
    # A step moves the body by the speed at its end: the speed at its beginning is half a step old.
    rates = 0.5 * (true[late] + true[late + 1])[:, 7:]
    return _read(true[rows], rates, rows * step_s, hidden, rng, noise)


def _read(
    pose: np.ndarray, rates: np.ndarray, t_s: np.ndarray, hidden: Hidden, rng: np.random.Generator, noise: float
) -> Recording:
    scale, clock = hidden.get("scale", 1.0), hidden.get("clock", 1.0)
    mounted = Rotation.from_rotvec([hidden.get("turned_rad", 0.0), 0.0, 0.0])
    turn = Rotation.from_quat(np.roll(pose[:, 3:7], -1, axis=1)) * mounted
    shake = Rotation.from_rotvec(rng.normal(0.0, 5e-4 * noise, (len(pose), 3)))
    recorded = rng.uniform(size=len(pose)) > 0.02
    return Recording(
        t_s=(t_s * clock)[recorded],
        p=(scale * pose[:, :3] + rng.normal(0.0, 5e-5 * noise, (len(pose), 3)))[recorded],
        quat_wxyz=np.roll((turn * shake).as_quat(), 1, axis=1)[recorded],
        v=(scale / clock * rates[:, :3] + rng.normal(0.0, 4e-3 * noise, (len(pose), 3)))[recorded],
        w=(mounted.inv().apply(rates[:, 3:]) / clock + rng.normal(0.0, 0.04 * noise, (len(pose), 3)))[recorded],
    )


def _force(hidden: Hidden, v: np.ndarray, w: np.ndarray) -> np.ndarray:
    drag = hidden.get("drag", 0.0) * v + hidden.get("square_drag", 0.0) * float(np.linalg.norm(v)) * v
    push = np.array([hidden.get("push_x", 0.0), hidden.get("push_y", 0.0), 0.0])
    return push - drag + hidden.get("magnus", 0.0) * np.cross(w, v)


def _document(box: Box, hidden: Hidden, step_s: float) -> str:
    g, tilt = hidden.get("g", 9.81), hidden.get("tilt_rad", 0.0)
    x, y, z = 0.5 * box.size_m * hidden.get("size", 1.0)
    ix, iy, iz = box.inertia * hidden.get("inertia", 1.0)
    centre = f"{hidden.get('com_x', 0.0)} {hidden.get('com_y', 0.0)} 0"
    contact = f'friction="{hidden.get("mu", box.mu)} 0 0" solref="0.004 {hidden.get("damping_ratio", 1.0)}"'
    return (
        f'<mujoco><option timestep="{step_s}" cone="elliptic" impratio="10" '
        f'gravity="{g * np.sin(tilt)} 0 {-g * np.cos(tilt)}"/><worldbody>'
        f'<geom type="plane" size="9 9 1" condim="3" {contact}/>'
        f'<body><freejoint/><inertial pos="{centre}" mass="{box.mass}" diaginertia="{ix} {iy} {iz}"/>'
        f'<geom type="box" size="{x} {y} {z}" condim="3" {contact}/></body></worldbody></mujoco>'
    )
