"""Cells forked from the warm process make the same packages as cold ones, byte for byte."""

from __future__ import annotations

import json
from pathlib import Path

from assetkit.discover import discover
from assetkit.ingest import Batch, ingest
from assetkit.options import Options
from cli.assets import PRELOAD, WORKER
from geom.gprims import cylinder
from jobs import warm
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem


def files(package: Path) -> dict[str, bytes]:
    return {p.relative_to(package).as_posix(): p.read_bytes() for p in package.rglob("*") if p.is_file()}


def test_warm_and_cold_packages_are_equal(tmp_path: Path):
    points, triangles, _ = cylinder(0.1, 0.05, 0.03, 8)
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    source = tmp_path / "post.obj"
    source.write_text("\n".join([*lines, ""]))
    items: dict[str, ReportItem] = {}
    for preload in (PRELOAD, ""):
        batch = Batch(tmp_path / (preload or "cold"), Options(units="m"), WORKER, preload)
        for item in ingest(discover([source]), batch):
            items[preload] = item
            served = warm._server is not None and warm._server.requests is not None
            assert served == bool(preload)
    assert items[PRELOAD].outcome is items[""].outcome is not ItemOutcome.REJECTED
    assert items[PRELOAD].codes == items[""].codes
    made, again = files(tmp_path / PRELOAD / "post"), files(tmp_path / "cold" / "post")
    records = [json.loads(package.pop("record.json")) for package in (made, again)]
    for record in records:
        record.pop("history")  # Keys of the store: they change when somebody edits the code meanwhile.
    assert records[0] == records[1]
    assert made == again != {}
