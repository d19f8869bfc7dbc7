"""A released package in MuJoCo: what the engine holds of it, and where drops on a plane end. Knows nothing of Mana.

Imported by the tests for URDF twins, and run as a script by the interpreter of the `mujoco-usd` environment for USD
files: a JSON request on stdin, a JSON answer on stdout. Metres, kilograms, seconds; quaternions wxyz.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

STRIDE = 5  # steps between two looks at the motion


@dataclass(frozen=True)
class Ground:
    """The plane z = 0 and the laws of contact on it, and what counts as rest (rms speed of the body's matter).

    `stiffness_s` is the time constant of MuJoCo's contact spring; a body at rest sinks in by about
    `0.1 g stiffness_s^2`. MuJoCo's own default is 0.02 s.
    """

    friction: float
    rolling_resistance_m: float
    turning_loss_per_s: float
    gravity_mps2: float
    still_mps: float
    hold_s: float
    duration_s: float
    timestep_s: float = 0.002
    stiffness_s: float = 0.005


def read(file: Path) -> mujoco.MjSpec:
    """The package file as MuJoCo reads it, with a free body and visuals that MuJoCo can bear.

    A URDF's first link is welded to the world, and then its mass is dropped, unless one says otherwise. MuJoCo decodes
    PNG textures only and refuses the model for any other; and for flat meshes, unless their inertia is that of a shell.
    """
    spec = mujoco.MjSpec.from_file(str(file))
    if file.suffix == ".urdf":
        spec.compiler.fusestatic = False
        spec.worldbody.first_body().add_freejoint()
    foreign = {t.name: t for t in spec.textures if t.file and not t.file.lower().endswith(".png")}
    for material in spec.materials:
        material.textures = ["" if name in foreign else name for name in material.textures]
    for texture in foreign.values():
        spec.delete(texture)
    for geom in spec.geoms:
        if geom.meshname and not geom.contype and not geom.conaffinity:
            spec.mesh(geom.meshname).inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    return spec


def refusal(file: Path) -> str:
    """Why MuJoCo refuses the file as it is; empty if it does not."""
    try:
        mujoco.MjSpec.from_file(str(file)).compile()
    except ValueError as error:
        return str(error)
    return ""


def facts(file: Path) -> dict[str, Any]:
    """What MuJoCo holds of the body in `file`: mass, mass centre, inertia about it (body axes), geoms, free or not."""
    model = read(file).compile()
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[1])
    R = axes.reshape(3, 3)
    return {
        "refusal": refusal(file),
        "bodies": model.nbody - 1,
        "free": bool(model.njnt == 1 and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE),
        "mass_kg": float(model.body_mass[1]),
        "centre_of_mass_m": model.body_ipos[1].tolist(),
        "inertia_kgm2": (R @ np.diag(model.body_inertia[1]) @ R.T).tolist(),
        "geoms": [
            {
                "name": model.geom(index).name,
                "kind": mujoco.mjtGeom(model.geom_type[index]).name.removeprefix("mjGEOM_").lower(),
                "collides": bool(model.geom_contype[index] or model.geom_conaffinity[index]),
                "friction": float(model.geom_friction[index][0]),
            }
            for index in range(model.ngeom)
        ],
    }


def on_ground(file: Path, ground: Ground) -> mujoco.MjModel:
    """The model of the body in `file` over the plane z = 0, every contact of it as `ground` says."""
    spec = read(file)
    spec.option.gravity = [0.0, 0.0, -ground.gravity_mps2]
    spec.option.timestep = ground.timestep_s
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    for geom in spec.geoms:
        geom.priority = 1  # its friction and stiffness hold for the pair
        geom.condim = 6  # with rolling
        geom.friction = [ground.friction, 1e-5, ground.rolling_resistance_m]
        geom.solref = [ground.stiffness_s, 1.0]
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0])
    return spec.compile()


def drop(model: mujoco.MjModel, pose_WA: Sequence[float], ground: Ground) -> dict[str, Any]:
    """Where the body comes to rest, released at rest in `pose_WA` (x, y, z, w, x, y, z), and whether it did."""
    data = mujoco.MjData(model)
    data.qpos[:] = pose_WA
    mass, centre = model.body_mass[1], model.body_ipos[1].copy()
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[1])
    R_AI, moments = axes.reshape(3, 3), model.body_inertia[1]
    kept = math.exp(-ground.turning_loss_per_s * STRIDE * ground.timestep_s)
    rest_s = 0.0
    while data.time < ground.duration_s and rest_s < ground.hold_s:
        mujoco.mj_step(model, data, nstep=STRIDE)
        data.qvel[3:] *= kept
        turning_A = data.qvel[3:]
        R_WA = data.xmat[1].reshape(3, 3)
        velocity = data.qvel[:3] + R_WA @ np.cross(turning_A, centre)
        squared = velocity @ velocity + moments @ (turning_A @ R_AI) ** 2 / mass
        rest_s = rest_s + STRIDE * ground.timestep_s if squared <= ground.still_mps**2 else 0.0
    return {"pose_WA": data.qpos.tolist(), "still": bool(rest_s >= ground.hold_s), "seconds": data.time}


def drop_all(file: Path, poses_WA: Sequence[Sequence[float]], ground: Ground) -> list[dict[str, Any]]:
    """One `drop` per pose."""
    model = on_ground(file, ground) if poses_WA else None
    return [drop(model, pose_WA, ground) for pose_WA in poses_WA]


def answer(request: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Facts and drops of every file asked for: `[{"file", "poses_WA", "ground"}]` -> `[{"facts", "drops"}]`."""
    answers = []
    for asked in request:
        file, ground = Path(asked["file"]), Ground(**asked["ground"])
        answers.append({"facts": facts(file), "drops": drop_all(file, asked["poses_WA"], ground)})
    return answers


if __name__ == "__main__":
    json.dump(answer(json.load(sys.stdin)), sys.stdout)
