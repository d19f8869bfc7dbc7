"""From one recorded episode to many: `replay.augment`.

    python examples/04_augment.py OUT    (after 01_ingest.py)

The recording is a smooth motion of the Franka arm of pybullet_data. Packages of 01 are put on the table outside the
proven swept volume of the arm; recorded states are copied bit for bit. Then a verifier measures all distances again.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pybullet_data

import replay

CANDIDATES = "cli.replay.candidates:candidates"  # offers packages of a library in their stable poses, by name
ROWS, PERIOD_S = 80, 0.05
FROM_RAD, TO_RAD = (0.5, 0.4, 0.0, -2.0, 0.0, 2.5, 0.8), (-0.6, 0.8, 0.0, -1.9, 0.0, 2.7, 0.8)
GRIPPER_M = {"panda_finger_joint1": 0.04, "panda_finger_joint2": 0.04}  # open; not recorded
TOP = {"type": "box", "name": "tabletop", "size_m": [0.7, 1.0, 0.04]}
TABLE = {"name": "table", "position_m": [0.55, 0.0, -0.08], "shapes": [TOP]}
SCENE = {"robots": [{"name": "panda", "model": "panda.urdf", "positions": GRIPPER_M}], "fixtures": [TABLE]}


def record(folder: Path, arm: Path) -> Path:
    """Write an episode folder: seven joints from one posture to another and back."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(arm / "panda.urdf", folder / "panda.urdf")
    (folder / "episode.json").write_text(json.dumps(SCENE, indent=1))
    t_s, phase = PERIOD_S * np.arange(ROWS), np.linspace(0.0, 2.0 * np.pi, ROWS)
    columns = {"t": t_s}
    for k, (start_rad, end_rad) in enumerate(zip(FROM_RAD, TO_RAD, strict=True), start=1):
        columns[f"q.panda_joint{k}"] = start_rad + (end_rad - start_rad) * (1.0 - np.cos(phase)) / 2.0
        columns[f"qd.panda_joint{k}"] = (end_rad - start_rad) * np.sin(phase) * np.pi / t_s[-1]
    pq.write_table(pa.table(columns), folder / "episode.parquet")
    return folder


def main(out: Path) -> None:
    """Make three variants with two new objects each; print what the verifier measures."""
    arm, library = Path(pybullet_data.getDataPath()) / "franka_panda", out / "library"
    episode, folder = record(out / "episodes" / "wave", arm), out / "augmented"
    result = replay.augment([episode], folder, assets=library, candidates=CANDIDATES, variants=3, objects=2, meshes=arm)
    for source, reason in result.refused:
        print(f"{source.name} refused: {reason.headline}")
    for check in replay.check_output(folder, library, None, meshes=arm):
        least_m = check.nearest.distance_m if check.nearest is not None else np.inf
        recording = "recording unchanged" if check.states_identical else "recording changed"
        print(f"{check.variant}: {check.objects_inserted} new objects, least distance {least_m:.3f} m; {recording}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
