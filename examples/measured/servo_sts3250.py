"""A Feetech STS3250 servo swinging a pendulum under its own position control.

Original: github.com/Rhoban/bam, commit b53408c (pull request 1), data_raw_feetech, Apache-2.0; paper as servo_xl330.

Expects `logs.npz` and `meta.json` as `servo_xl330` does; the load register is zero throughout.

Assumed: the firmware's position loop is proportional, with 0.166 duty per rad and unit of gain, as the source measured
on the smaller STS3215 of the same family; duty times the stall torque is the torque at standstill. Datasheet at 12 V:
stall 50 kg cm (4.9 N m), no-load 0.133 s per 60 degrees. Back-EMF, stall torque over no-load speed, is declared as
damping. Rows come 45 to 60 times a second and unevenly: good for latency, too coarse for fine friction.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from examples.measured.folder import Part, named, packed, run
from examples.measured.servo_xl330 import COLUMNS, pendulum

DUTY_PER_RAD_AND_GAIN = 0.166
STALL_NM = 50.0 * 9.81e-2
NO_LOAD_RADPS = np.radians(60.0) / 0.133


def parts(source: Path) -> Sequence[Part]:
    """One measurement with a table per log."""
    meta = json.loads((source / "meta.json").read_text())
    tables = {}
    for log_id, rows in packed(source / "logs.npz"):
        columns = named(COLUMNS, rows)
        del columns["load"]
        tables[log_id] = columns
    first = meta[next(iter(tables))]
    spec = {
        "schema_version": 1,
        "name": "servo_sts3250",
        "kind": "mechanism",
        "description": "servo with a pendulum of 1.13 kg at 0.12 m under position control",
        "source": "Rhoban/bam b53408c",
        "licence": "Apache-2.0",
        "columns": {"t": "t", "q_servo": "angle", "qd_servo": "speed", "command_servo": "goal"},
        "aux": {"supply_V": "supply", "temperature_C": "temperature", "torque_enabled": "enabled"},
        "subject": {"joints": [pendulum(first, STALL_NM / NO_LOAD_RADPS)]},
        "actuation": {
            "type": "position_pd",
            "kp": round(DUTY_PER_RAD_AND_GAIN * first["kp"] * STALL_NM, 6),
            "kd": 0.0,
            "effort_limit": round(STALL_NM, 6),
        },
    }
    return (Part("", spec, tables),)


if __name__ == "__main__":
    run(parts)
