"""A Dynamixel XL330 servo swinging a pendulum with four firmware gains.

Original: github.com/Rhoban/bam, commit af22604, bam/data.bak/raw, Apache-2.0. Duclusaud, Passault, Padois, Ly, Extended
Friction Models for the Physics Simulation of Servo Actuators, ICRA 2025.

Expects `logs.npz`: ids, start, length, data (rows, 8) = t, goal position, torque enable, position (0 = hanging), speed,
load register, supply voltage, temperature; and `meta.json`: per id mass, length, kp, vin.

Assumed: the load register is the duty cycle times 885 (it equals the firmware's proportional law on the logged
positions), and duty times the stall torque is the motor's torque at standstill. Datasheet of the M288 version at 5 V:
stall 0.52 N m, no-load 103 rev/min; both scaled to the supply of 7.4 V. Back-EMF, stall torque over no-load speed, is
declared as damping; it is absent while torque is off (`lift_and_drop`). The mass is a point at the arm's end; the arm's
own mass, the gears' inertia and their friction are unknown and not declared.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from examples.measured.folder import Part, named, packed, run

DUTY_COUNTS = 885.0
STALL_NM_AT_5V = 0.52
NO_LOAD_RADPS_AT_5V = 103.0 * 2.0 * np.pi / 60.0
COLUMNS = "t goal enabled angle speed load supply temperature"


def pendulum(meta: dict[str, Any], damping: float) -> dict[str, Any]:
    """The joint with a point mass on an arm."""
    mass, length = meta["mass"], meta["length"]
    return {
        "name": "servo",
        "type": "revolute",
        "inertia_kgm2": mass * length**2,
        "gravity_load": {"mass_kg": mass, "com_distance_m": length},
        "damping": round(damping, 6),
    }


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per log."""
    meta = json.loads((source / "meta.json").read_text())
    tables = {}
    for log_id, rows in packed(source / "logs.npz"):
        columns = named(COLUMNS, rows)
        tables[log_id] = {**columns, "duty": columns.pop("load") / DUTY_COUNTS}
    first = meta[next(iter(tables))]
    stall = STALL_NM_AT_5V * first["vin"] / 5.0
    spec = {
        "schema_version": 1,
        "name": "servo_xl330",
        "kind": "mechanism",
        "description": "servo with a pendulum of 0.49 kg at 0.1 m; four trajectories, four gains",
        "source": "Rhoban/bam af22604",
        "licence": "Apache-2.0",
        "columns": {
            "t": "t",
            "q_servo": "angle",
            "qd_servo": "speed",
            "effort_servo": "duty",
            "command_servo": "goal",
        },
        "aux": {"supply_V": "supply", "temperature_C": "temperature", "torque_enabled": "enabled"},
        "subject": {"joints": [pendulum(first, stall / (NO_LOAD_RADPS_AT_5V * first["vin"] / 5.0))]},
        "actuation": {"type": "effort", "effort_per_unit": round(stall, 6)},
    }
    return (Part("", spec, tables),)


if __name__ == "__main__":
    run(parts)
