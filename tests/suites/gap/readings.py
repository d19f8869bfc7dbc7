"""What a logger makes of a motion: encoder steps, noise, late and uneven stamps, lost rows, wrong zero or scale."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.measurement import MeasurementSpec
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial
from tests.suites.gap.truth import STEP_S, Hidden, Plant

COUNT = 2.0 * np.pi / 4096  # a 12-bit encoder
NOISE = COUNT / np.sqrt(12.0)
_JITTER = 0.03  # of a row, one standard deviation; the logger stamps what it reads
_LOST = 0.01


def read(
    motion: np.ndarray, hidden: Hidden, row_s: float, noise: float, colour: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps (k, rows), readings (k, rows, j) and which rows were kept (k, rows) of a motion (k, steps, j).

    noise   in steps of a 12-bit encoder's own; colour: share of an error that stays to the next row.
    """

    def h(name: str) -> float | np.ndarray:
        return hidden.get(name, 0.0)

    trials, steps, joints = motion.shape
    fine = np.arange(steps) * STEP_S
    rows = round(steps * STEP_S / row_s)
    t = np.arange(rows) * row_s + np.clip(rng.normal(0.0, _JITTER, (trials, rows)), -0.2, 0.2) * row_s
    t = np.clip(t, 0.0, fine[-1])
    late, slow = (float(np.max(h(name))) for name in ("latency_s", "sensor_lag_s"))
    motion = _low_passed(motion, slow) if slow > 0.0 else motion
    q = np.stack([[np.interp(t[k] - late, fine, motion[k, :, j]) for j in range(joints)] for k in range(trials)])
    q = q.transpose(0, 2, 1) * (1.0 + h("scale_share")) + h("zero_rad")
    error = rng.normal(0.0, noise * NOISE, q.shape)
    for k in range(1, rows if colour else 0):
        error[:, k] = colour * error[:, k - 1] + np.sqrt(1.0 - colour**2) * error[:, k]
    count = COUNT if noise else 1e-9
    recorded = rng.random((trials, rows)) >= _LOST
    recorded[:, [0, -1]] = True
    return t * (1.0 + float(np.max(h("clock_share")))), np.round((q + error) / count) * count, recorded


def _low_passed(motion: np.ndarray, slow_s: float) -> np.ndarray:
    """What a resistor and a capacitor make of a motion (k, steps, j) that begins at rest: step by step, trapezoidal."""
    share = 0.5 * STEP_S / slow_s
    out = motion.copy()
    for step in range(1, motion.shape[1]):
        driven = share * (motion[:, step] + motion[:, step - 1])
        out[:, step] = ((1.0 - share) * out[:, step - 1] + driven) / (1.0 + share)
    return out


def measurement(
    name: str, plant: Plant, logs: tuple[np.ndarray, np.ndarray, np.ndarray], inputs: np.ndarray, supply_V: np.ndarray
) -> Measurement:
    """The declared plant with its logs, as the reader would give them."""
    t, q, kept = logs
    spec = declared_spec(plant)
    trials = tuple(
        _trial(f"t{k:02d}", plant.drive, t[k, keep], q[k, keep], inputs[k, keep], supply_V[k, keep])
        for k, keep in enumerate(kept)
    )
    return Measurement(spec, trials, Path("."), name, tuple(joint.name for joint in spec.subject.joints))


def declared_spec(plant: Plant) -> MeasurementSpec:
    """What the plant's owner writes into `measurement.yaml`."""
    joints = [_declared(plant, j) for j in range(len(plant.inertia))]
    return MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "case",
            "kind": "mechanism",
            "columns": {"t": "t", **{f"q_{j['name']}": f"q_{j['name']}" for j in joints}},
            "subject": {"joints": joints},
            "actuation": {"type": plant.drive, "kp": plant.kp, "kd": plant.kd},
        }
    )


def _declared(plant: Plant, j: int) -> dict[str, object]:
    joint: dict[str, object] = {"name": ("axis", "elbow")[j], "friction": plant.friction, "damping": plant.damping}
    if plant.slides:
        return joint | {"type": "prismatic", "mass_kg": float(plant.inertia[j])}
    load = {"mass_kg": float(plant.mass[j]), "com_distance_m": float(plant.lever[j])}
    joint |= {"type": "revolute", "inertia_kgm2": float(plant.inertia[j]), "gravity_load": load}
    return joint | {"parent_offset_m": plant.offset_m if j else 0.0}


def _trial(name: str, drive: str, t_s: np.ndarray, q: np.ndarray, given: np.ndarray, supply_V: np.ndarray) -> Trial:
    n, joints = q.shape

    def absent(width: int) -> np.ndarray:
        return np.full((n, width), np.nan)

    return Trial(
        id=name,
        t_s=t_s - t_s[0],
        p=absent(3),
        quat_wxyz=absent(4),
        v_W=absent(3),
        w_B=absent(3),
        q=q,
        qd=absent(joints),
        command_p=absent(3),
        command_quat_wxyz=absent(4),
        effort=given if drive == "effort" else absent(joints),
        command=given if drive == "position_pd" else absent(joints),
        aux={} if drive == "none" else {"supply_V": supply_V},
    )
