"""Tosses of an acrylic cube onto a board, tracked by tags.

Original: github.com/DAIRLab/contact-nets (data/tosses_processed) and github.com/DAIRLab/dair_pll
(assets/contactnets_cube), BSD-3-Clause. Pfrommer, Halm, Posa, ContactNets, CoRL 2020; Acosta, Yang, Posa, RA-L 2022.

Expects `tosses.npz`: ids, start, length, data (rows, 13) = position of the cube's centre, quaternion wxyz, velocity
(world), angular velocity (body axes), SI units, board at z = 0, each distinct toss once.

Assumed: 148 Hz, as contact-nets does (the raw stamps average 148.3 Hz, dair_pll uses 0.0068 s). The source files hold
copies of tosses turned about the vertical; converting all of them is safe, since the reader finds copies. Mass and
inertia are the sources' nominal values; friction 0.5 and restitution 0 are what a simulator assumes before anyone
measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from examples.measured.folder import Part, named, packed, run

SIDE_M = 0.1048


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per toss."""
    columns = "px py pz qw qx qy qz vx vy vz wx wy wz"
    tables = {f"toss_{i}": named(columns, rows) for i, rows in packed(source / "tosses.npz")}
    spec = {
        "schema_version": 1,
        "name": "cube_toss",
        "kind": "free_body",
        "description": "acrylic cube tossed onto a flat board, tag-tracked",
        "source": "DAIRLab/contact-nets, DAIRLab/dair_pll",
        "licence": "BSD-3-Clause",
        "rate_hz": 148.0,
        "columns": {
            "p": ["px", "py", "pz"],
            "q_wxyz": ["qw", "qx", "qy", "qz"],
            "v": ["vx", "vy", "vz"],
            "w_body": ["wx", "wy", "wz"],
        },
        "subject": {
            "box": {"size_m": [SIDE_M] * 3},
            "mass_kg": 0.37,
            "inertia_kgm2": [0.00081] * 3,
            "contact": {"friction": 0.5, "restitution": 0.0},
        },
        "world": {
            "gravity_mps2": [0.0, 0.0, -9.81],
            "support": {"plane": {"normal": [0.0, 0.0, 1.0], "height_m": 0.0}},
        },
    }
    return (Part("", spec, tables),)


if __name__ == "__main__":
    run(parts)
