"""From recordings to the effect that a model lacks: `simgap.find`.

    python examples/05_find_gap.py OUT

The recordings are generated: a door on a vertical axis is pushed by hand, let go, and slows down by dry friction in its
hinge, read by an encoder of 12 bits. The declared model has inertia and no friction. The search fits candidates on
training trials, compares them on held-out trials, and names the effect with its size and interval.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import simgap

REPLAY_ENGINE = "sim.bullet.replay_engine:BulletReplayEngine"  # the engine that rolls out free bodies, by name
FRICTION_NM, INERTIA_KGM2 = 0.008, 0.01
TRIALS, SPAN_S, PERIOD_S, STEP_RAD = 10, 3.0, 0.01, 2.0 * np.pi / 2**12
MEASUREMENT = f"""\
schema_version: 1
name: door
kind: mechanism
columns: {{t: t, q_door: angle}}
subject:
  joints: [{{name: door, inertia_kgm2: {INERTIA_KGM2}}}]
"""


def record(folder: Path) -> Path:
    """Write a measurement folder: pushes to both sides, with the rate falling at the same pace until the door stops."""
    (folder / "trajectories").mkdir(parents=True, exist_ok=True)
    (folder / "measurement.yaml").write_text(MEASUREMENT)
    rng, t_s = np.random.default_rng(0), np.arange(0.0, SPAN_S, PERIOD_S)
    for k in range(TRIALS):
        rate_radps, slowing_radps2 = rng.uniform(0.8, 3.0), FRICTION_NM / INERTIA_KGM2
        moving_s = np.minimum(t_s, rate_radps / slowing_radps2)
        angle_rad = (-1) ** k * (rate_radps * moving_s - slowing_radps2 * moving_s**2 / 2.0)
        read_rad = STEP_RAD * np.round((angle_rad + rng.uniform(0.0, STEP_RAD)) / STEP_RAD)
        table, file = np.stack([t_s, read_rad], axis=1), folder / "trajectories" / f"push_{k}.csv"
        np.savetxt(file, table, fmt="%.6f", delimiter=",", header="t,angle", comments="")
    return folder


def main(out: Path) -> None:
    """Search the gap; print the verdict, and the parameters beside those that made the recordings."""
    report = simgap.find(record(out / "door"), out / "gap", engine=REPLAY_ENGINE, quick=True)
    print(f"{report.verdict.status}: {report.verdict.statement}")
    for effect in report.verdict.effects:
        for name, size in effect.parameters.items():
            low, high = size.ci95
            print(f"  {effect.name} at {effect.where.joint}: {name} {size.value:.5f} [{low:.5f}, {high:.5f}]", end="")
            print(f" {size.unit}; in the recordings {FRICTION_NM}")
    print(f"{out / 'gap' / 'report.html'} shows the search")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
