"""A Franka Emika Panda arm following one exciting trajectory: joint positions, velocities and torques.

Original: github.com/marcocognetti/FrankaEmikaPandaDynModel, matlab/data/Exciting_Traj/Trajectory_1, GPL-3.0: keep the
data apart from permissively licensed files. Gaz, Cognetti, Oliva, Robuffo Giordano, De Luca, RA-L 2019.

Expects `log.npz`: t (n,), q, dq, tau (n, 7).

Assumed: tau, of the link-side torque sensors, is the effort that moves the links; the arm stands upright and carries no
hand. The model is written from the manufacturer's public numbers: Denavit-Hartenberg lengths and the link masses, mass
centres and inertias of franka_description (Apache-2.0), which go back to the same paper. Friction is not declared.
One run only: it is cut into segments of about 1 s, and blocks of neighbours go to one side of the split.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from examples.measured.folder import Part, in_blocks, named, run, segments

ROWS = 1000


class Link(NamedTuple):
    """Where the joint sits in the link before (m, rad about x), then mass, mass centre, and xx yy zz xy xz yz of it."""

    place: str
    roll: float
    mass_kg: float
    com_m: str
    inertia_kgm2: tuple[float, float, float, float, float, float]


_QUARTER = np.pi / 2.0
LINKS = (
    Link(
        "0 0 0.333",
        0.0,
        4.970684,
        "0.003875 0.002081 -0.04762",
        (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169),
    ),
    Link(
        "0 0 0",
        -_QUARTER,
        0.646926,
        "-0.003141 -0.02872 0.003495",
        (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704),
    ),
    Link(
        "0 -0.316 0",
        _QUARTER,
        3.228604,
        "0.027518 0.039252 -0.066502",
        (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805),
    ),
    Link(
        "0.0825 0 0",
        _QUARTER,
        3.587895,
        "-0.05317 0.104419 0.027454",
        (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641),
    ),
    Link(
        "-0.0825 0.384 0",
        -_QUARTER,
        1.225946,
        "-0.011953 0.041065 -0.038437",
        (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229),
    ),
    Link(
        "0 0 0",
        _QUARTER,
        1.666555,
        "0.060149 -0.014117 -0.010517",
        (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341),
    ),
    Link(
        "0.088 0 0",
        _QUARTER,
        0.735522,
        "0.010517 -0.004252 0.061597",
        (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741),
    ),
)


def urdf() -> str:
    """The arm without shapes."""
    lines = ['<robot name="panda">', '  <link name="link0"/>']
    for k, link in enumerate(LINKS, 1):
        xx, yy, zz, xy, xz, yz = link.inertia_kgm2
        inertia = f'ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="{xy}" ixz="{xz}" iyz="{yz}"'
        lines += [
            f'  <link name="link{k}">',
            f'    <inertial><origin xyz="{link.com_m}"/><mass value="{link.mass_kg}"/><inertia {inertia}/></inertial>',
            "  </link>",
            f'  <joint name="joint{k}" type="continuous">',
            f'    <parent link="link{k - 1}"/><child link="link{k}"/>',
            f'    <origin xyz="{link.place}" rpy="{link.roll:.12g} 0 0"/><axis xyz="0 0 1"/>',
            "  </joint>",
        ]
    return "\n".join([*lines, "</robot>", ""])


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per segment."""
    with np.load(source / "log.npz") as log:
        columns = {"t": log["t"]}
        for array, name in (("q", "angle"), ("dq", "rate"), ("tau", "torque")):
            columns |= named(" ".join(f"{name}{k}" for k in range(1, 8)), log[array].astype(np.float64))
    tables = segments(columns, ROWS)
    spec = {
        "schema_version": 1,
        "name": "panda_exciting",
        "kind": "mechanism",
        "description": "robot arm on an exciting trajectory",
        "source": "marcocognetti/FrankaEmikaPandaDynModel",
        "licence": "GPL-3.0",
        "columns": {"t": "t"}
        | {f"q_joint{k}": f"angle{k}" for k in range(1, 8)}
        | {f"qd_joint{k}": f"rate{k}" for k in range(1, 8)}
        | {f"effort_joint{k}": f"torque{k}" for k in range(1, 8)},
        "subject": {"urdf": "panda.urdf"},
        "actuation": {"type": "effort", "effort_per_unit": 1.0},
        "split": in_blocks(list(tables)),
    }
    return (Part("", spec, tables, {"panda.urdf": urdf()}),)


if __name__ == "__main__":
    run(parts)
