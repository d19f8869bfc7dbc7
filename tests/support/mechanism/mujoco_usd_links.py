"""What MuJoCo's USD reader holds of articulated packages: links with masses, joints, and link poses at joint positions.

A script for the interpreter of the `mujoco-usd` environment, which knows nothing of Mana: a JSON request on stdin
({"file", "states": [{joint: position}]}), a JSON answer on stdout. SI units, quaternions wxyz.

MuJoCo 4.0 makes a body of its own of the prim with the articulation root, without mass, and refuses to compile it; it
refuses flat render meshes as well. Both are taken out of the model before it is compiled; nothing else is.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np


def read(file: Path) -> mujoco.MjModel:
    """The model of a USD file, without geoms that do not collide and without bodies that hold nothing."""
    spec = mujoco.MjSpec.from_file(str(file))
    for geom in [g for g in spec.geoms if not g.contype and not g.conaffinity]:
        spec.delete(geom)
    for body in [b for b in spec.bodies if b.name and not b.geoms and not b.bodies and not b.explicitinertial]:
        if body.name != "world":
            spec.delete(body)
    return spec.compile()


def last(name: str) -> str:
    """The name of a prim without its path."""
    return name.rpartition("/")[2]


def facts(model: mujoco.MjModel) -> dict[str, Any]:
    """Masses of links and numbers of joints by name; a free root link is no joint."""
    free = mujoco.mjtJoint.mjJNT_FREE
    joints = [model.joint(i) for i in range(model.njnt) if model.jnt_type[i] != free]
    return {
        "masses_kg": {last(model.body(i).name): float(model.body_mass[i]) for i in range(1, model.nbody)},
        "joints": {
            last(joint.name): {
                "slides": bool(joint.type[0] == mujoco.mjtJoint.mjJNT_SLIDE),
                "axis": np.asarray(joint.axis).tolist(),
                "child": last(model.body(joint.bodyid[0]).name),
                "limits": np.asarray(joint.range).tolist() if model.jnt_limited[joint.id] else None,
            }
            for joint in joints
        },
    }


def link_poses(model: mujoco.MjModel, state: dict[str, float]) -> dict[str, list[float]]:
    """Position and quaternion (7,) of each link in the world."""
    data = mujoco.MjData(model)
    for i in range(model.njnt):
        name = last(model.joint(i).name)
        if name in state:
            data.qpos[model.jnt_qposadr[i]] = model.qpos0[model.jnt_qposadr[i]] + state[name]
    mujoco.mj_kinematics(model, data)
    return {last(model.body(i).name): [*data.xpos[i], *data.xquat[i]] for i in range(1, model.nbody)}


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """The answer to one request."""
    model = read(Path(request["file"]))
    return facts(model) | {"poses": [link_poses(model, state) for state in request["states"]]}


if __name__ == "__main__":
    json.dump(answer(json.load(sys.stdin)), sys.stdout)
