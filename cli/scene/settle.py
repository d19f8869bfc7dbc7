"""Let a written scene go in PyBullet: the entry point of a cell, and what is made of its answer."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from pathlib import Path

from geom.pose import angle_between, quat_of
from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.warm import run_module
from schemas.scene.compiled import Settling
from sim.port import PlacedBody
from usdio.reread.scene import reread_scene

DURATION_S = 1.0  # A thing that loses its support falls 5 mm in 32 ms; what tips over takes longer to start.
MOST_MOVED_M, MOST_TURNED_RAD = 0.005, math.radians(3.0)
LIMITS = Limits(seconds=300.0, memory_mb=4096)


def settle(scene_usda: Path) -> tuple[Settling, ...]:
    """How far each object of the written scene goes from its pose when all are let go, in a process of its own.

    Raises RuntimeError when the engine crashes or hangs: a broken environment, not a bad scene.
    """
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        note = Path(folder) / "settling.json"
        result = run_module("cli.scene.settle", [str(scene_usda), str(note)], LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"settling {result.status}: {result.output[-1500:]}")
        return tuple(Settling.model_validate(row) for row in json.loads(note.read_bytes()))


def settled(scene_usda: Path, duration_s: float = DURATION_S) -> tuple[Settling, ...]:
    """The same in this process: bodies as read back from disk, released at rest where the scene has them."""
    from sim.bullet.scene import settle_scene  # PyBullet prints when it is imported.

    bodies = reread_scene(scene_usda)
    ends = settle_scene([PlacedBody(b.body, b.X_WA, b.moves) for b in bodies], duration_s)
    rows = []
    for body, X_WA in zip(bodies, ends, strict=True):
        if body.moves:
            moved_m = math.dist(X_WA[:3, 3], body.X_WA[:3, 3])
            turned_rad = float(angle_between(quat_of(X_WA[:3, :3]), quat_of(body.X_WA[:3, :3])))
            stayed = moved_m <= MOST_MOVED_M and turned_rad <= MOST_TURNED_RAD
            rows.append(Settling(id=body.name, moved_m=moved_m, turned_rad=turned_rad, stayed=stayed))
    return tuple(rows)


def main(scene_usda: str, note: str) -> None:
    """Settle the scene and leave the rows in `note`."""
    rows = [row.model_dump() for row in settled(Path(scene_usda))]
    write_atomically(Path(note), json.dumps(rows).encode())


if __name__ == "__main__":
    main(*sys.argv[1:3])
