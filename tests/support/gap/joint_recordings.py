"""Measurement folders of one driven joint whose dry friction its owner does not know of, without any simulator."""

from __future__ import annotations

from pathlib import Path

import numpy as np

TURNING = "{name: axis, inertia_kgm2: 0.02}"
SLIDING = "{name: axis, type: prismatic, mass_kg: 95.0}"
_ROW_S = 4e-3
_SPEC = """\
schema_version: 1
name: {name}
kind: mechanism
columns: {{t: t, q_axis: position, effort_axis: effort}}
world: {{gravity_mps2: [0, 0, 0]}}
subject:
  joints: [{joint}]
actuation: {{type: effort}}
"""


def driven_joint(folder: Path, joint: str, inertia: float, friction: float, name: str = "driven axis") -> Path:
    """Six trials of sine waves; effort = inertia * acceleration + friction against the rate, in SI of the joint."""
    (folder / "trajectories").mkdir(parents=True)
    (folder / "measurement.yaml").write_text(_SPEC.format(name=name, joint=joint))
    t_s = np.arange(0.0, 2.0, _ROW_S)
    rng = np.random.default_rng(5)
    for k in range(6):
        rate_radps, size = 4.0 + 0.7 * k, 0.2 + 0.05 * k
        q = size * np.sin(rate_radps * t_s)
        phase = rate_radps * (t_s + 0.5 * _ROW_S)  # An effort is held from its row to the next.
        effort = -inertia * rate_radps**2 * size * np.sin(phase) + friction * np.sign(np.cos(phase))
        table = np.stack([t_s, q + rng.normal(0.0, 1e-5, len(q)), effort], axis=1)
        header = "t,position,effort"
        np.savetxt(folder / "trajectories" / f"s{k}.csv", table, delimiter=",", header=header, comments="")
    return folder
