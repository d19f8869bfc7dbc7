"""The same things in MuJoCo: another engine's integrator and its own friction, damping, springs and limits."""

from __future__ import annotations

from typing import Any

import mujoco as _mujoco
import numpy as np

from tests.suites.gap.truth import STEP_S, Hidden, Plant

mujoco: Any = _mujoco  # a C extension without types
KNOWN = frozenset({"viscous", "coulomb", "spring", "rest", "inertia_share", "gain_share", "push", "tilt_rad"})


def simulate(plant: Plant, hidden: Hidden, inputs: np.ndarray, start: np.ndarray, row_s: float) -> np.ndarray:
    """Positions (k, steps, j) every `STEP_S`, as `truth.simulate` gives them. Raises KeyError for other effects."""
    unknown = {n for n, v in hidden.items() if np.any(np.asarray(v) != 0.0)} - KNOWN - {"teeth", "seed"}
    if unknown:
        raise KeyError(f"not made in MuJoCo: {', '.join(sorted(unknown))}")
    model = mujoco.MjModel.from_xml_string(_document(plant, hidden))
    data = mujoco.MjData(model)
    every = round(row_s / STEP_S)
    gain = 1.0 + _joint(hidden, "gain_share", start.shape[1])
    push = _joint(hidden, "push", start.shape[1])
    out = np.empty((len(inputs), inputs.shape[1] * every, start.shape[1]))
    for k, command in enumerate(inputs):
        mujoco.mj_resetData(model, data)
        data.qpos[:] = start[k]
        for step in range(out.shape[1]):
            out[k, step] = data.qpos
            if plant.drive != "none":
                sent = command[step // every]
                asked = plant.kp * (sent - data.qpos) - plant.kd * data.qvel if plant.drive == "position_pd" else sent
                data.qfrc_applied[:] = gain * asked + push
            mujoco.mj_step(model, data)
    return out


def _joint(hidden: Hidden, name: str, joints: int) -> np.ndarray:
    return np.broadcast_to(np.asarray(hidden.get(name, 0.0), dtype=float), (joints,))


def _document(plant: Plant, hidden: Hidden) -> str:
    joints = len(plant.inertia)
    tilt = float(np.max(hidden.get("tilt_rad", 0.0)))
    gravity = f"{-9.81 * np.sin(tilt)} 0 {-9.81 * np.cos(tilt)}"
    bodies, ends = "", ""
    for j in range(joints):
        kind, axis = ("slide", "1 0 0") if plant.slides else ("hinge", "0 1 0")
        mass, lever = float(plant.mass[j]), float(plant.lever[j])
        spin = max(float(plant.inertia[j]) - mass * lever**2, 1e-9) if not plant.slides else 1e-3
        extra = _joint(hidden, "inertia_share", joints)[j] * plant.inertia[j]
        damping = plant.damping * (1.0 + _joint(hidden, "damping_share", joints)[j])
        bodies += (
            f'<body pos="0 0 {-plant.offset_m if j else 0.0}"><joint type="{kind}" axis="{axis}" armature="{extra}" '
            f'damping="{damping + _joint(hidden, "viscous", joints)[j]}" '
            f'frictionloss="{plant.friction + _joint(hidden, "coulomb", joints)[j]}" '
            f'stiffness="{_joint(hidden, "spring", joints)[j]}" springref="{_joint(hidden, "rest", joints)[j]}"/>'
            f'<inertial pos="0 0 {-lever}" mass="{mass}" diaginertia="{spin} {spin} {spin}"/>'
        )
        ends += "</body>"
    option = f'<option timestep="{STEP_S}" gravity="{gravity}" integrator="implicitfast"/><compiler angle="radian"/>'
    return f"<mujoco>{option}<worldbody>{bodies}{ends}</worldbody></mujoco>"
