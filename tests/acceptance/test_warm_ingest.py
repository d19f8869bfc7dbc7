"""Cells forked from the warm process make the same packages as cold ones, byte for byte."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from assetkit.batch import item_cells
from assetkit.batch.item_cells import PRELOAD, Batch, run_items
from assetkit.options import Options
from assetkit.sources.discover import discover
from cli.engines import SIMULATOR
from geom.mesh.primitives import cylinder
from jobs import warm
from jobs.cell import Limits
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem


def files(package: Path) -> dict[str, bytes]:
    return {p.relative_to(package).as_posix(): p.read_bytes() for p in package.rglob("*") if p.is_file()}


THREADS = """
import os
from manifold3d import Manifold
Manifold.sphere(1.0, 200).hull().to_mesh()
print(len(os.listdir("/proc/self/task")))
"""


def test_libraries_of_a_warm_cell_keep_to_one_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "count_threads.py").write_text(THREADS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    with warm.warm_cells(PRELOAD, env={"OMP_NUM_THREADS": "1", "PXR_WORK_THREAD_LIMIT": "1"}):
        result = warm.run_module("count_threads", [], Limits(60.0, 8192))
    assert (result.status, result.output.strip()) == ("ok", "1")


@pytest.mark.parametrize("ready_studio_from", [1, 2])
def test_warm_and_cold_packages_are_equal(ready_studio_from: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """With pictures from a ready studio and from new ones."""
    monkeypatch.setattr(item_cells, "READY_STUDIO_FROM", ready_studio_from)
    points, triangles, _ = cylinder(0.1, 0.05, 0.03, 8)
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    source = tmp_path / "post.obj"
    source.write_text("\n".join([*lines, ""]))
    items: dict[str, ReportItem] = {}
    for preload in (PRELOAD, ""):
        batch = Batch(tmp_path / (preload or "cold"), Options(units="m"), SIMULATOR, preload=preload)
        for item in run_items(discover([source]), batch):
            items[preload] = item
            served = isinstance(warm._runner, warm.ForkServer) and warm._runner.requests is not None
            assert served == bool(preload)
    assert items[PRELOAD].outcome is items[""].outcome is not ItemOutcome.REJECTED
    assert items[PRELOAD].codes == items[""].codes
    made, again = files(tmp_path / PRELOAD / "post"), files(tmp_path / "cold" / "post")
    records = [json.loads(package.pop("record.json")) for package in (made, again)]
    for record in records:
        record.pop("history")  # Keys of the store: they change when somebody edits the code meanwhile.
    assert records[0] == records[1]
    assert made == again != {}
