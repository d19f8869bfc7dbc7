"""A toss as the finder reads it: trajectories with noise, and the measurement."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import GRAVITY
from tests.suites.gap2.generate.cases import CaseFiles
from tests.suites.gap2.generate.logs import csv_bytes, digest_of
from tests.suites.gap2.generate.tosses.recording import TrackedToss
from tests.suites.gap2.generate.truth import Truth

_NAMES = ("px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")


def toss_files(truth: Truth, tracked: TrackedToss, readings: Array, rng: np.random.Generator) -> CaseFiles:
    box, with_rates, declares = tracked.box, bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    dropped = float(rng.choice([0.0, 0.0, 0.02]))
    files = {}
    for k, (t, true) in enumerate(zip(tracked.t_s, readings, strict=True)):
        read = true.copy()
        read[:, :3] += rng.normal(0.0, tracked.sigma_m, (len(t), 3))
        shake = Rotation.from_rotvec(rng.normal(0.0, tracked.sigma_rad, (len(t), 3)))
        read[:, 3:7] = np.roll((Rotation.from_quat(np.roll(true[:, 3:7], -1, axis=1)) * shake).as_quat(), 1, axis=1)
        read[:, 7:10] += rng.normal(0.0, 20.0 * tracked.sigma_m, (len(t), 3))
        read[:, 10:] += rng.normal(0.0, 20.0 * tracked.sigma_rad, (len(t), 3))
        rows = rng.random(len(t)) >= dropped
        rows[[0, -1]] = True
        names = _NAMES if with_rates else _NAMES[:7]
        table = {"t": t[rows], **{n: read[rows, i] for i, n in enumerate(names)}}
        files[f"trajectories/r{k:02d}.csv"] = csv_bytes(table, list(table))
    measurement = digest_of(files)
    columns: dict[str, object] = {"t": "t", "p": list(_NAMES[:3]), "q_wxyz": list(_NAMES[3:7])}
    if with_rates:
        columns |= {"v": list(_NAMES[7:10]), "w_body": list(_NAMES[10:])}
    height_m = 0.0 if box.slides or box.tumbles else -6.0
    spec: dict[str, object] = {
        "schema_version": 1,
        "name": measurement,
        "kind": "free_body",
        "rate_hz": round(tracked.rate_hz, 3),
        "columns": columns,
        "subject": {
            "box": {"size_m": _short(box.size_m)},
            "mass_kg": _short([box.mass_kg])[0],
            "inertia_kgm2": _short(box.inertia_kgm2),
            "contact": {"friction": _short([box.mu])[0], "restitution": 0.0},
        },
        "world": {
            "gravity_mps2": [0.0, 0.0, -GRAVITY],
            "support": {"plane": {"height_m": height_m}},
        },
    }
    if declares:
        spec["sensor_noise"] = {"p_m": _short([tracked.sigma_m])[0], "rotation_rad": _short([tracked.sigma_rad])[0]}
    files["measurement.yaml"] = (json.dumps(spec, indent=1) + "\n").encode()
    log = {"rate_hz": tracked.rate_hz, "trials": len(tracked.t_s), "rows": int(tracked.t_s.size)}
    return CaseFiles(files, replace(truth, measurement=measurement, log=log))


def _short(values: Sequence[float] | Array) -> list[float]:
    return [float(f"{v:.9g}") for v in values]
