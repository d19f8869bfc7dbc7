"""A ball-screw positioning axis under position control (EMPS).

Original: nonlinearbenchmark.org, "EMPS"; the same numbers in github.com/forgi86/sysid-neural-continuous
(examples/EMPS/data, Apache-2.0) and github.com/wmkouw/NSI-EMPS. The benchmark itself states no licence: cite Janot,
Gautier, Brunot, 2019 Workshop on Nonlinear System Identification Benchmarks, and ask before publishing the data.

Expects `emps.npz`: t, q_ref, q in m, u_volt, and the drive gain gtau in N/V.

Assumed: force on the slide = gtau times controller voltage, held from row to row; the moving mass is the published
95.11 kg. The authors also identified a viscous friction of 203.5 N s/m, a Coulomb friction of 20.4 N and an offset of
-3.2 N: they are what a search should find, so the model is written without friction.
The run is cut into segments of about 2 s; blocks of neighbours go to one side of the split.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from examples.measured.folder import Part, in_blocks, run, segments

ROWS = 2000


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per segment."""
    with np.load(source / "emps.npz") as log:
        columns = {"t": log["t"], "position": log["q"], "reference": log["q_ref"], "voltage": log["u_volt"]}
        newton_per_volt = float(log["gtau"])
    tables = segments(columns, ROWS)
    spec = {
        "schema_version": 1,
        "name": "emps",
        "kind": "mechanism",
        "description": "ball-screw axis under position control",
        "source": "nonlinearbenchmark.org EMPS",
        "licence": "not stated by the benchmark; copies Apache-2.0 and MIT",
        "rate_hz": 1000.0,
        "columns": {"t": "t", "q_slide": "position", "effort_slide": "voltage", "command_slide": "reference"},
        "subject": {"joints": [{"name": "slide", "type": "prismatic", "mass_kg": 95.1089}]},
        "actuation": {"type": "effort", "effort_per_unit": newton_per_volt},
        "split": in_blocks(list(tables)),
    }
    return (Part("", spec, tables),)


if __name__ == "__main__":
    run(parts)
