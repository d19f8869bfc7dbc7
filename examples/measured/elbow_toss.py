"""Tosses of two blocks joined by a free hinge onto a board, tracked by tags.

Original: github.com/DAIRLab/dair_pll, tag v0.0.2, assets/contactnets_elbow, BSD-3-Clause. Bianchini, Halm, Posa,
Simultaneous Learning of Contact and Continuous Dynamics, CoRL 2023.

Expects `tosses.npz`: ids, start, length, data (rows, 15) = position of link 1's origin, its quaternion wxyz, hinge
angle (wrapped), velocity (world), angular velocity (body axes of link 1), hinge rate; SI units, board at z = 0.

Assumed: 148 Hz; every toss is cut to 121 frames, about half still move at the end. The model written beside the data
has the source's nominal numbers: two boxes of 0.37 kg with isotropic inertia, friction 0.3, a hinge without friction.
The two links do not collide with each other, as in the source.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from examples.measured.folder import Part, named, packed, run

INERTIA = " ".join(
    f'i{axes}="{0.0006167 if axes[0] == axes[1] else 0}"' for axes in ("xx", "xy", "xz", "yy", "yz", "zz")
)
JOINT = """\
  <joint name="elbow" type="continuous">
    <parent link="link_1"/>
    <child link="link_2"/>
    <origin xyz="-0.035 0.06 0"/>
    <axis xyz="0 1 0"/>
  </joint>
"""


def link(name: str, centre: str) -> str:
    """A block whose centre stands at `centre` of its frame."""
    shape = f'<origin xyz="{centre}"/><geometry><box size="0.1 0.05 0.05"/></geometry>'
    return (
        f'  <link name="{name}">\n'
        f'    <inertial><origin xyz="{centre}"/><mass value="0.37"/><inertia {INERTIA}/></inertial>\n'
        f"    <visual>{shape}</visual>\n"
        f"    <collision>{shape}</collision>\n"
        "  </link>\n"
    )


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per toss and the two-link model."""
    columns = "px py pz qw qx qy qz theta vx vy vz wx wy wz theta_rate"
    tables = {f"toss_{i}": named(columns, rows) for i, rows in packed(source / "tosses.npz")}
    spec = {
        "schema_version": 1,
        "name": "elbow_toss",
        "kind": "free_body",
        "description": "two blocks on a free hinge tossed onto a flat board, tag-tracked",
        "source": "DAIRLab/dair_pll v0.0.2",
        "licence": "BSD-3-Clause",
        "rate_hz": 148.0,
        "columns": {
            "p": ["px", "py", "pz"],
            "q_wxyz": ["qw", "qx", "qy", "qz"],
            "v": ["vx", "vy", "vz"],
            "w_body": ["wx", "wy", "wz"],
            "q_elbow": "theta",
            "qd_elbow": "theta_rate",
        },
        "subject": {"urdf": "elbow.urdf", "contact": {"friction": 0.3, "restitution": 0.0}},
        "world": {
            "gravity_mps2": [0.0, 0.0, -9.81],
            "support": {"plane": {"normal": [0.0, 0.0, 1.0], "height_m": 0.0}},
        },
    }
    urdf = f'<robot name="elbow">\n{link("link_1", "0 0 0")}{link("link_2", "0.035 0 0")}{JOINT}</robot>\n'
    return (Part("", spec, tables, {"elbow.urdf": urdf}),)


if __name__ == "__main__":
    run(parts)
