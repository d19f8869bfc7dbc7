"""`mana assets ingest --watch` on a folder into which files come: whole ones, a slow copy, one that is no mesh."""

from __future__ import annotations

import json
import signal
import subprocess
import threading
import time
from pathlib import Path
from queue import Queue
from typing import IO, Any

import trimesh

from assetkit.package.record import read_record
from jobs.lock import LOCK
from tests.acceptance.test_pipeline import MANA
from tests.support.bad_inputs.assets import obj_text

SETTLE_S = 1.0
ITEM_S = 240.0  # of one small item on a machine that does other work; usually about 10 s


def lines_of(stream: IO[str]) -> Queue[dict[str, Any]]:
    """The lines of JSON that a process prints, as they come."""
    lines: Queue[dict[str, Any]] = Queue()

    def read() -> None:
        for line in stream:
            lines.put(json.loads(line))

    threading.Thread(target=read, daemon=True).start()
    return lines


def test_files_are_taken_up_as_they_come_and_ctrl_c_ends_with_0(tmp_path: Path) -> None:
    inbox, out = tmp_path / "inbox", tmp_path / "library"
    inbox.mkdir()
    box = obj_text(trimesh.creation.box((0.1, 0.08, 0.06)))
    (inbox / "first.obj").write_text(box)
    command = [*MANA, "assets", "ingest", str(inbox), "--watch", "--units", "m", "--jobs", "1", "--json"]
    command += ["--settle", str(SETTLE_S), "--out", str(out)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)
    try:
        assert process.stdout is not None
        items = lines_of(process.stdout)
        first = items.get(timeout=ITEM_S)
        assert (Path(first["source"]).name, first["packages"]) == ("first.obj", ["first"])

        (inbox / "broken.stl").write_text("no mesh")
        lines = obj_text(trimesh.creation.box((0.12, 0.08, 0.06))).splitlines(keepends=True)
        with (inbox / "slow.obj").open("w") as file:  # a copy whose pauses are shorter than --settle
            for line in lines:
                file.write(line)
                file.flush()
                time.sleep(min(0.4 * SETTLE_S, 4.0 * SETTLE_S / len(lines)))
        broken = items.get(timeout=ITEM_S)
        assert (Path(broken["source"]).name, broken["outcome"]) == ("broken.stl", "rejected")
        slow = items.get(timeout=ITEM_S)
        assert (Path(slow["source"]).name, slow["packages"]) == ("slow.obj", ["slow"])

        end = time.monotonic() + 60.0
        while (out / LOCK).exists():  # The pass writes its report; between passes the folder is free.
            assert time.monotonic() < end
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60.0)
        assert (process.returncode, errors) == (0, "")
    finally:
        process.kill()
    report = json.loads((out / "report.json").read_text())
    outcomes = {Path(item["source"]).name: item["packages"] for item in report["items"]}
    assert outcomes == {"broken.stl": [], "first.obj": ["first"], "slow.obj": ["slow"]}
    assert report["totals"]["items"] == 3
    record = read_record(out / "slow")
    assert record is not None
    assert max(record.geometry.extent_m.value) == 0.12
    assert items.empty()
