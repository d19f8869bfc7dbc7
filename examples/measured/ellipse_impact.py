"""Planar impacts of a dropped ellipse: the state just before and just after, one row per event.

Original: github.com/DAIRLab/ImpactModeling, ExploringErrors/Angles/ellipse_uniform.mat (data of N. Fazeli),
BSD-3-Clause. Fazeli, Zapolsky, Drumwright, Rodriguez, CoRL 2017, arXiv 1710.05947.

Expects `impacts.npz`: ids, pre and post (n, 6) = x, y, angle, vx, vy, angular rate; normal_jac and tangent_jac (n, 3);
flags (n, k), the source's own marks.

Assumed: a homogeneous ellipse of 0.037 kg with semi-axes 35 and 25 mm. All events are written, flagged or not: the
flags have no published meaning. Friction and restitution are what a simulator assumes before anyone measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from examples.measured.folder import Part, named, run

SEMI_AXES_M = (0.035, 0.025)
MASS_KG = 0.037


def parts(source: Path) -> Sequence[Part]:
    """One measurement with one table."""
    with np.load(source / "impacts.npz") as archive:
        columns = {
            "id": archive["ids"].astype(np.float64),
            **named("x0 y0 angle0 vx0 vy0 rate0", archive["pre"]),
            **named("x1 y1 angle1 vx1 vy1 rate1", archive["post"]),
            **named("nx ny nw", archive["normal_jac"]),
            **named("tx ty tw", archive["tangent_jac"]),
        }
    a, b = SEMI_AXES_M
    about_z = MASS_KG * (a**2 + b**2) / 4.0
    spec = {
        "schema_version": 1,
        "name": "ellipse_impact",
        "kind": "impact",
        "description": "planar impacts of a dropped ellipse",
        "source": "DAIRLab/ImpactModeling",
        "licence": "BSD-3-Clause",
        "columns": {
            "id": "id",
            "pose_before": ["x0", "y0", "angle0"],
            "velocity_before": ["vx0", "vy0", "rate0"],
            "pose_after": ["x1", "y1", "angle1"],
            "velocity_after": ["vx1", "vy1", "rate1"],
            "normal_jacobian": ["nx", "ny", "nw"],
            "tangent_jacobian": ["tx", "ty", "tw"],
        },
        "subject": {
            "mass_kg": MASS_KG,
            "inertia_kgm2": [MASS_KG * b**2 / 4.0, MASS_KG * a**2 / 4.0, about_z],
            "contact": {"friction": 0.5, "restitution": 0.0},
        },
    }
    return (Part("", spec, {"impacts": columns}),)


if __name__ == "__main__":
    run(parts)
