"""A whole ingest beside plain CoACD with default settings, on the same real meshes, in one run.

    python -m benchmarks.assets.ingest [OUT_DIR]

Prints one line per mesh: seconds of every Mana stage together, seconds of its collision stage, hulls and
95th-percentile surface distance, beside the seconds and hulls of `coacd.run_coacd(mesh)` in a process of its own
(120 s limit).
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from assetkit.batch.item_cells import Batch, run_items
from assetkit.options import Options
from assetkit.package.record import RECORD
from assetkit.sources.discover import discover
from cli.demo.app import OBJECTS, data_folder
from cli.engines import SIMULATOR
from jobs.cell import Limits, run_cell
from schemas.asset import AssetRecord

PLAIN = """
import sys, time, coacd, trimesh
mesh = trimesh.load(sys.argv[1], force="mesh")
coacd.set_log_level("error")
started = time.monotonic()
parts = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces))
print("RESULT", time.monotonic() - started, len(parts))
"""


def main() -> None:
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp(prefix="mana-bench"))
    meshes = [data_folder() / name for name in OBJECTS]
    batch = Batch(out=out, options=Options(), engine=SIMULATOR, fresh=True)
    print(
        f"{'mesh':20} {'all s':>7} {'coll s':>7} {'shapes':>6} {'p95 %':>6}   {'plain s':>8} {'hulls':>5} {'ratio':>6}"
    )
    for item in run_items(discover(meshes), batch):
        plain_s, hulls = plain_coacd(item.source)
        ours_s = sum(item.seconds.values())
        for name in item.packages:
            record = AssetRecord.model_validate_json((out / name / RECORD).read_bytes())
            chosen = next(c for c in record.physics.candidates if c.method == record.physics.collision_method)
            p95 = 100 * max(chosen.outside_p95, chosen.missing_p95)
            collision_s = item.seconds.get("physics", 0.0)
            ratio = collision_s / plain_s if plain_s else float("nan")
            figures = (ours_s, collision_s, chosen.shapes, p95, plain_s, hulls, ratio)
            print(f"{name:20}" + "".join(f"{f:8.2f}" for f in figures), flush=True)


def plain_coacd(mesh: str) -> tuple[float, int]:
    """Seconds and hull count of CoACD with its defaults; the limit and 0 hulls when it does not finish."""
    limit = Limits(seconds=120.0, memory_mb=8192)
    result = run_cell([sys.executable, "-c", PLAIN, mesh], limit, env={"OMP_NUM_THREADS": "1"})
    for line in result.output.splitlines():
        if line.startswith("RESULT"):
            _, seconds, hulls = line.split()
            return float(seconds), int(hulls)
    return result.seconds, 0


if __name__ == "__main__":
    main()
