"""The driver is killed at random moments and started again: nothing is lost, half-written or done twice."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from assetkit.library import catalog
from assetkit.library.doctor import examine

SAMPLE = Path(__file__).parents[2] / "data" / "record.json"
ITEMS, ITEM_S = 40, 0.08
CELL = f"""
import json, sys, time
from pathlib import Path
from assetkit.batch import result_store
from assetkit.batch.item_cells import candidate_of
from assetkit.package.release import publish
from jobs.cache import file_sha256
from schemas.report import ReportItem
if __name__ == '__main__':
    request = json.loads(Path(sys.argv[1]).read_text())
    candidate, out = candidate_of(request), Path(request['out'])
    name = candidate.asset_id
    folder = Path(request['work_dir']) / 'package' / name
    (folder / 'usd').mkdir(parents=True)
    time.sleep({ITEM_S})
    layer = folder / 'usd' / 'layer.usda'
    layer.write_text('#usda 1.0' + chr(10) * 20000)
    record = json.loads(Path({str(SAMPLE)!r}).read_text())
    record |= {{'asset_id': name, 'hashes': {{'usd/layer.usda': file_sha256(layer)}}}}
    (folder / 'record.json').write_text(json.dumps(record))
    publish(folder, out / name)
    item = ReportItem(source=candidate.given, outcome='accepted', packages=(name,))
    result_store.write_stored(Path(request['note']), result_store.stored_from(item, candidate, out))
"""
DRIVER = """
import sys
from pathlib import Path
from unittest import mock
from assetkit.batch import run_batch
from assetkit.batch.item_cells import Batch
from functools import partial
from jobs.placement import Placement
if __name__ == '__main__':
    with mock.patch.object(run_batch, 'Batch', partial(Batch, worker='a_killable_cell', preload='a_killable_cell')):
        done = run_batch.ingest([Path(sys.argv[1])], Path(sys.argv[2]), engine='no:engine', placement=Placement(2))
        print(int(done.totals['cached']), int(done.totals['accepted']))
"""


@pytest.mark.parametrize("kills", [pytest.param(4, id="a slice"), pytest.param(20, id="all", marks=pytest.mark.long)])
def test_a_killed_driver_loses_nothing_and_does_nothing_twice(kills: int, tmp_path: Path):
    sources, out = tmp_path / "in", tmp_path / "out"
    sources.mkdir()
    for number in range(ITEMS):
        (sources / f"part_{number}.obj").write_text(f"v {number} 0 0\n")
    (tmp_path / "a_killable_cell.py").write_text(CELL)
    (tmp_path / "driver.py").write_text(DRIVER)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    argv = [sys.executable, str(tmp_path / "driver.py"), str(sources), str(out)]

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(argv, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True)

    draw = random.Random(20261126)
    stored: set[str] = set()
    for _ in range(kills):
        driver = start()
        end = time.monotonic() + draw.uniform(0.3, 1.3)
        while driver.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        if driver.poll() is None:
            os.killpg(driver.pid, signal.SIGKILL)
        driver.communicate()
        now = {note.name for note in (out / ".cache" / "items").glob("*.json")}
        assert stored <= now  # What is finished stays finished.
        stored = now
        wait_for_cells()
        assert examine(out).healthy if out.exists() else True
    written = {note: (out / ".cache" / "items" / note).stat().st_mtime_ns for note in stored}
    said, _ = start().communicate()
    cached, accepted = (int(word) for word in said.split())
    assert (cached, accepted) == (len(stored), ITEMS)
    assert {note: (out / ".cache" / "items" / note).stat().st_mtime_ns for note in stored} == written
    assert examine(out).findings == ()
    assert [row["asset_id"] for row in catalog.listing(out)] == sorted(f"part_{n}" for n in range(ITEMS))
    report = json.loads((out / "report.json").read_text())
    assert len(report["items"]) == ITEMS


def wait_for_cells() -> None:
    """Until no process of the batch is left: cells die with their driver."""
    end = time.monotonic() + 10.0
    while any("a_killable_cell" in line for line in listing()):
        assert time.monotonic() < end, "a cell outlived its driver"
        time.sleep(0.02)


def listing() -> list[str]:
    return subprocess.run(["ps", "-ewwo", "args"], capture_output=True, text=True, check=True).stdout.splitlines()
