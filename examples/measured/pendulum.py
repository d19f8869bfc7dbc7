"""Free swings of a single, a double and a triple pendulum: parts `single`, `double`, `triple`.

Original: github.com/dynamicslab/MultiArm-Pendulum, ParameterEstimation, MIT. Kaheman et al., The Experimental Multi-Arm
Pendulum on a Cart, arXiv 2205.06231.

Expects `single.npz`, `double.npz`, `triple.npz` (any of them): ids, start, length, data (rows, 2 N) = absolute angles
(pi = hanging at rest) and their rates, 1 kHz. The source has smoothed the rates (median and wavelet).

Assumed: joint angles here are 0 when every link hangs: the first is the absolute angle less pi, the others are
differences to the link above. Single arm: mass, lever and inertia as the source estimated them. Double and triple arms:
the numbers of the source's own simulation script; its inertias are taken about each link's axis, because the energy of
the recorded double swings is then constant to 1 to 9 %, and to 30 to 100 % if they are taken about the mass centres.
No friction is declared; the source estimated viscous friction only.
All segments of one kind come from one recording, and the swing falls with their number: blocks of neighbours go to one
side of the split.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from examples.measured.folder import Part, in_blocks, named, packed, run


class Arm(NamedTuple):
    """One link: mass, distance of its centre from its axis, inertia about that axis, and distance to the next axis."""

    mass_kg: float
    lever_m: float
    inertia_kgm2: float
    length_m: float


SINGLE = (Arm(0.147585, 0.147755, 0.00010912 + 0.147585 * 0.147755**2, 0.0),)
CHAIN = (
    Arm(0.11, 0.08755, 0.001578, 0.1727),
    Arm(0.12, 0.127, 0.0029, 0.2286),
    Arm(0.10, 0.12, 0.002157, 0.2413),
)
ARMS = {"single": SINGLE, "double": CHAIN[:2], "triple": CHAIN}


def joints(arms: Sequence[Arm]) -> list[dict[str, Any]]:
    """The chain from base to tip."""
    return [
        {
            "name": f"joint_{k + 1}",
            "type": "revolute",
            "inertia_kgm2": round(arm.inertia_kgm2, 9),
            "gravity_load": {"mass_kg": arm.mass_kg, "com_distance_m": arm.lever_m},
            "parent_offset_m": arms[k - 1].length_m if k else 0.0,
        }
        for k, arm in enumerate(arms)
    ]


def table(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Stamps, joint angles and rates of one segment."""
    count = rows.shape[1] // 2
    absolute, rates = rows[:, :count] - np.pi, rows[:, count:]
    relative = np.column_stack([absolute[:, :1], np.diff(absolute, axis=1)])
    turning = np.column_stack([rates[:, :1], np.diff(rates, axis=1)])
    names = " ".join([f"angle_{k + 1}" for k in range(count)] + [f"rate_{k + 1}" for k in range(count)])
    return {"t": np.arange(len(rows)) / 1000.0, **named(names, np.column_stack([relative, turning]))}


def parts(source: Path) -> Sequence[Part]:
    """One measurement for each kind that is there."""
    made = []
    for kind, arms in ARMS.items():
        if not (source / f"{kind}.npz").is_file():
            continue
        tables = {segment: table(rows) for segment, rows in packed(source / f"{kind}.npz")}
        numbers = range(1, len(arms) + 1)
        spec = {
            "schema_version": 1,
            "name": f"pendulum_{kind}",
            "kind": "mechanism",
            "description": f"free swings of a {kind} pendulum",
            "source": "dynamicslab/MultiArm-Pendulum",
            "licence": "MIT",
            "rate_hz": 1000.0,
            "columns": {"t": "t"}
            | {f"q_joint_{k}": f"angle_{k}" for k in numbers}
            | {f"qd_joint_{k}": f"rate_{k}" for k in numbers},
            "subject": {"joints": joints(arms)},
            "split": in_blocks(sorted(tables)),
        }
        made.append(Part(kind, spec, tables))
    return made


if __name__ == "__main__":
    run(parts)
