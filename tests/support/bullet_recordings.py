"""Episodes recorded in PyBullet, in Mana's own folder format, with stamps as a real logger leaves them.

`sweep`: one arm sweeps low over its table. `two_arms`: two arms face each other. `drawer`: an arm beside a drawer that
opens and carries a block out. Joints are driven by motors; what is recorded is what the engine did. Link poses as the
engine has them go to `links_fk.parquet`.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pybullet
import pybullet_data

DATA = Path(pybullet_data.getDataPath()) / "franka_panda"
HOME = (0.0, 0.3, 0.0, -2.2, 0.0, 2.5, 0.8)
STEP_S = 1.0 / 240.0
BLOCK_M = (0.05, 0.05, 0.05)
DRAWER = """<robot name="drawer">
  <link name="cabinet"><collision><origin xyz="0 0 0.17"/><geometry><box size="0.3 0.3 0.02"/></geometry></collision>
    <collision><origin xyz="0 0 0.01"/><geometry><box size="0.3 0.3 0.02"/></geometry></collision></link>
  <link name="tray"><inertial><mass value="0.5"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>
    <collision><origin xyz="0 0 0.03"/><geometry><box size="0.26 0.26 0.01"/></geometry></collision>
    <collision><origin xyz="-0.13 0 0.07"/><geometry><box size="0.01 0.26 0.08"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="cabinet"/><child link="tray"/><axis xyz="-1 0 0"/>
    <limit lower="0" upper="0.25" effort="50" velocity="1"/></joint>
</robot>
"""
BASES = {
    "sweep": {"panda": (0.0, 0.0, 0.0)},
    "two_arms": {"left": (0.0, 0.35, 0.0), "right": (0.0, -0.35, 0.0)},
    "drawer": {"panda": (0.0, 0.0, 0.0), "drawer": (0.6, 0.3, 0.0)},
}


def record(folder: Path, kind: str, seconds: float = 2.0, seed: int = 0) -> Path:
    """The folder with a recording of `kind`; the same seed gives the same motion."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(DATA / "panda.urdf", folder / "panda.urdf")
    (folder / "drawer.urdf").write_text(DRAWER)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        rows, links = _simulate(folder, kind, seconds, np.random.default_rng(seed), client)
    finally:
        pybullet.disconnect(client)
    for name, table in (("episode.parquet", rows), ("links_fk.parquet", links)):
        pq.write_table(pa.table({c: np.array([row[c] for row in table]) for c in table[0]}), folder / name)
    (folder / "episode.json").write_text(json.dumps(_description(kind), indent=1))
    return folder


def _simulate(folder: Path, kind: str, seconds: float, rng: np.random.Generator, client: int) -> tuple[Any, Any]:
    pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
    bodies = {}
    for name, base in BASES[kind].items():
        file = folder / "drawer.urdf" if name == "drawer" else DATA / "panda.urdf"
        bodies[name] = pybullet.loadURDF(str(file), base, useFixedBase=1, physicsClientId=client)
        if name != "drawer":
            for joint, angle in zip(range(7), HOME, strict=True):
                pybullet.resetJointState(bodies[name], joint, angle, physicsClientId=client)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[s / 2 for s in BLOCK_M], physicsClientId=client
    )
    at = (0.6, 0.3, 0.062) if kind == "drawer" else (0.45, 0.0, 0.025)
    block = pybullet.createMultiBody(0.1, shape, basePosition=at, physicsClientId=client)
    ground = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.8, 0.8, 0.05], physicsClientId=client)
    pybullet.createMultiBody(0.0, ground, basePosition=(0.4, 0.0, -0.05), physicsClientId=client)
    rows, links, log_at = [], [], 0.0
    for step in range(round(seconds / STEP_S)):
        t = step * STEP_S
        _drive(bodies, kind, t, seconds, client)
        pybullet.stepSimulation(physicsClientId=client)
        if t >= log_at:
            rows.append(_row(t, bodies, block, client))
            links.append(_links(t, bodies, client))
            if rng.uniform() < 0.1:  # The same sample logged twice, under one stamp.
                rows.append(rows[-1])
                links.append(links[-1])
            log_at = t + rng.choice([0.004, 0.02, 0.05, 0.12])
    return rows, links


def _drive(bodies: dict[str, int], kind: str, t: float, seconds: float, client: int) -> None:
    phase = 2.0 * np.pi * t / seconds
    for name, body in bodies.items():
        if name == "drawer":
            open_hdf5 = 0.2 * np.sin(phase / 4.0) ** 2
            pybullet.setJointMotorControl2(
                body, 0, pybullet.POSITION_CONTROL, open_hdf5, force=50.0, physicsClientId=client
            )
            continue
        side = -1.0 if name == "right" else 1.0
        low = 0.35 if kind == "sweep" else 0.1
        goal = np.array(HOME) + np.array([side * 0.9 * np.sin(phase), low, 0.0, 0.0, 0.0, low, 0.0])
        for joint in range(7):
            pybullet.setJointMotorControl2(
                body, joint, pybullet.POSITION_CONTROL, goal[joint], force=87.0, physicsClientId=client
            )
        for joint in (9, 10):
            pybullet.setJointMotorControl2(
                body, joint, pybullet.POSITION_CONTROL, 0.02 * (1.0 + np.sin(phase)), physicsClientId=client
            )


def _row(t: float, bodies: dict[str, int], block: int, client: int) -> dict[str, float]:
    row = {"t": t}
    for name, body in bodies.items():
        for joint in range(pybullet.getNumJoints(body, physicsClientId=client)):
            info = pybullet.getJointInfo(body, joint, physicsClientId=client)
            if info[2] != pybullet.JOINT_FIXED:
                state = pybullet.getJointState(body, joint, physicsClientId=client)
                row[f"q.{name}.{info[1].decode()}"], row[f"qd.{name}.{info[1].decode()}"] = state[0], state[1]
    position, quat_xyzw = pybullet.getBasePositionAndOrientation(block, physicsClientId=client)
    return row | _pose("obj.block", position, quat_xyzw)


def _links(t: float, bodies: dict[str, int], client: int) -> dict[str, float]:
    row = {"t": t}
    for name, body in bodies.items():
        for joint in range(pybullet.getNumJoints(body, physicsClientId=client)):
            link = pybullet.getJointInfo(body, joint, physicsClientId=client)[12].decode()
            state = pybullet.getLinkState(body, joint, computeForwardKinematics=1, physicsClientId=client)
            row |= _pose(f"{name}.{link}", state[4], state[5])
    return row


def _pose(name: str, position: Any, quat_xyzw: Any) -> dict[str, float]:
    keys = [f"{name}.{c}" for c in ("px", "py", "pz", "qx", "qy", "qz", "qw")]
    return dict(zip(keys, (*position, *quat_xyzw), strict=True))


def _description(kind: str) -> dict[str, Any]:
    robots = [
        {"name": name, "model": "drawer.urdf" if name == "drawer" else "panda.urdf", "position_m": base}
        for name, base in BASES[kind].items()
    ]
    table = {"type": "box", "name": "table_top", "size_m": [1.6, 1.6, 0.1], "position_m": [0.4, 0.0, -0.05]}
    wrist = {"name": "wrist", "fovy_deg": 60.0, "robot": next(iter(BASES[kind])), "link": "panda_hand"}
    front = {"name": "front", "fovy_deg": 45.0, "position_m": [1.6, 0.0, 0.8], "quat_wxyz": [0.56, 0.43, 0.43, 0.56]}
    return {
        "name": kind,
        "robots": robots,
        "objects": [{"name": "block", "shapes": [{"type": "box", "size_m": BLOCK_M}]}],
        "fixtures": [{"name": "table", "shapes": [table]}],
        "cameras": [front, wrist],
    }


if __name__ == "__main__":
    record(Path(sys.argv[1]), sys.argv[2])
