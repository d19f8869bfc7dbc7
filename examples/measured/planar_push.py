"""Single-point pushes of a right-triangle block on two boards with five supports: parts such as `wood_three_10_90`.

Original: github.com/robinzhoucmu/PlanarManipulationToolBox, icra_data_proc/SensorLogs, GPL-2.0: keep the data apart
from permissively licensed files. Zhou, Paolini, Bagnell, Mason, ICRA 2016, arXiv 1602.06056.

Expects `pushes.npz`: ids (surface_support_number); pre_pose and post_pose (n, 7) = x, y, z, quaternion wxyz of the
tracked frame; force (t, fx, fy in sensor axes) and robot (t, x, y, z, quaternion wxyz of the tip), each with
`<name>_start` and `<name>_length` per push.

Assumed: the force on the block is minus the sensor's reading, turned by 45 degrees in the tool as the source does it,
less its first sample, and turned by the tip's heading into world axes. The tracked frame stands at the right-angled
corner, axes along the legs, at half height; the thickness follows from the mass if the block is steel. Friction is the
ratio of the source's mean pushing force to the weight. One part is one board with one support, because the pressure
under the block belongs to the subject.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from examples.measured.folder import Columns, Part, named, run

LEG_M, MASS_KG, STEEL_KGM3 = 0.15, 1.518, 7850.0
FRICTION = {"abs": 0.282, "wood": 0.336}
HALF_HEIGHT_M = MASS_KG / (0.5 * LEG_M**2 * STEEL_KGM3) / 2.0
SENSOR_TO_TOOL = np.sqrt(0.5) * np.array([[1.0, 1.0], [1.0, -1.0]])
_POSE = "x y z qw qx qy qz"


def block() -> str:
    """The prism as OBJ, in the tracked frame."""
    corners = [(x, y, z) for z in (-HALF_HEIGHT_M, HALF_HEIGHT_M) for x, y in ((0.0, 0.0), (LEG_M, 0.0), (0.0, LEG_M))]
    faces = ["1 3 2", "4 5 6", "1 2 5", "1 5 4", "2 3 6", "2 6 5", "3 1 4", "3 4 6"]
    return "".join(f"v {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in corners) + "".join(f"f {f}\n" for f in faces)


def force_on_block(readings: np.ndarray, tip: np.ndarray) -> np.ndarray:
    """(n, 2) N in world axes from sensor readings (n, 2) and the tip's quaternion wxyz (4,), which is constant."""
    in_tool = -readings @ SENSOR_TO_TOOL.T
    yaw = 2.0 * np.arctan2(tip[3], tip[0])
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return (in_tool - in_tool[0]) @ turn.T


def tables_of(archive: dict[str, np.ndarray], k: int) -> dict[str, Columns]:
    """Pose, tip and force tables of one push."""
    force, robot = (
        archive[name][archive[f"{name}_start"][k] :][: archive[f"{name}_length"][k]].astype(np.float64)
        for name in ("force", "robot")
    )
    on_block = force_on_block(force[:, 1:], robot[0, 4:])
    return {
        "pose": named(_POSE, np.stack([archive["pre_pose"][k], archive["post_pose"][k]]).astype(np.float64)),
        "tip": named(f"t {_POSE}", robot),
        "force": {"t": force[:, 0], **named("fx fy", on_block)},
    }


def spec_of(group: str) -> dict[str, Any]:
    """The measurement of one board and support."""
    surface, support = group.split("_", 1)
    about_corner = MASS_KG * LEG_M**2 / 6.0  # a right triangle about one of its equal legs
    about_com = about_corner - MASS_KG * (LEG_M / 3.0) ** 2
    height = MASS_KG * (2.0 * HALF_HEIGHT_M) ** 2 / 12.0
    quaternion = ["qw", "qx", "qy", "qz"]
    return {
        "schema_version": 1,
        "name": f"planar_push_{group}",
        "kind": "push",
        "description": f"right-triangle block on a board of {surface}, support {support}",
        "source": "robinzhoucmu/PlanarManipulationToolBox",
        "licence": "GPL-2.0",
        "columns": {
            "p": ["x", "y", "z"],
            "q_wxyz": quaternion,
            "tip_t": "t",
            "tip_p": ["x", "y", "z"],
            "tip_q_wxyz": quaternion,
            "force_t": "t",
            "force": ["fx", "fy"],
        },
        "subject": {
            "mesh": "block.obj",
            "mass_kg": MASS_KG,
            "inertia_kgm2": [about_com + height, about_com + height, 2.0 * about_com],
            "com_m": [LEG_M / 3.0, LEG_M / 3.0, 0.0],
            "contact": {"friction": FRICTION[surface], "restitution": 0.0},
        },
        "world": {
            "gravity_mps2": [0.0, 0.0, -9.81],
            "support": {"plane": {"normal": [0.0, 0.0, 1.0], "height_m": 0.0}},
        },
    }


def parts(source: Path) -> Sequence[Part]:
    """One measurement per board and support."""
    with np.load(source / "pushes.npz") as stored:
        archive = {name: stored[name] for name in stored.files}
    groups: dict[str, dict[str, Columns]] = {}
    for k, push in enumerate(map(str, archive["ids"])):
        group, number = push.rsplit("_", 1)
        for part, columns in tables_of(archive, k).items():
            groups.setdefault(group, {})[f"push_{number}.{part}"] = columns
    return [Part(group, spec_of(group), tables, {"block.obj": block()}) for group, tables in sorted(groups.items())]


if __name__ == "__main__":
    run(parts)
