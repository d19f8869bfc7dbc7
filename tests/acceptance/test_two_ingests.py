"""Two commands that write into one output folder at the same time: the first ends right, the second changes nothing."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import trimesh

from jobs.lock import LOCK
from tests.acceptance.test_pipeline import MANA, mana
from tests.support.bad_inputs.assets import obj_text

BOX = trimesh.creation.box((0.1, 0.08, 0.06))


def start(*arguments: str | Path) -> subprocess.Popen[str]:
    """An ingest that has the lock of its output folder and has begun with a source."""
    out = Path(arguments[-1])
    pipe = subprocess.PIPE
    process = subprocess.Popen([*MANA, "assets", "ingest", *map(str, arguments)], stdout=pipe, stderr=pipe, text=True)
    deadline = time.monotonic() + 60.0
    while not list(out.glob(".work/*/request.json")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return process


def sources(folder: Path, *names: str) -> Path:
    folder.mkdir()
    for number, name in enumerate(names):
        mesh = BOX.copy()
        mesh.apply_scale(1.0 + 0.1 * number)
        (folder / f"{name}.obj").write_text(obj_text(mesh))
    return folder


def test_the_second_ingest_into_a_folder_ends_at_once_and_the_first_ends_right(tmp_path: Path):
    out = tmp_path / "library"
    first, second = sources(tmp_path / "one", "a", "b"), sources(tmp_path / "two", "c")
    running = start(first, "--units", "m", "--out", out)
    refused = subprocess.run(
        [*MANA, "assets", "ingest", str(second), "--out", str(out)], capture_output=True, text=True, check=False
    )
    assert running.poll() is None, "the first ended before the second was tried"
    assert refused.returncode == 2
    [line] = refused.stderr.splitlines()
    assert str(out) in line
    assert f"process {running.pid};" in line
    printed, errors = running.communicate(timeout=300)
    assert running.returncode == 0, printed + errors
    report = json.loads((out / "report.json").read_text())
    assert [i["packages"] for i in report["items"]] == [["a"], ["b"]]
    assert not (out / LOCK).exists()
    mana("assets", "ingest", second, "--units", "m", "--out", out)
    assert [row["asset_id"] for row in json.loads(mana("assets", "list", out, "--json"))] == ["a", "b", "c"]


def test_a_killed_ingest_blocks_nobody_and_the_next_one_finishes_its_work(tmp_path: Path):
    out, folder = tmp_path / "library", sources(tmp_path / "one", "a")
    running = start(folder, "--units", "m", "--out", out)
    os.kill(running.pid, signal.SIGKILL)
    running.communicate()
    assert (out / LOCK).exists()
    mana("assets", "ingest", folder, "--units", "m", "--out", out)
    report = json.loads((out / "report.json").read_text())
    assert [i["packages"] for i in report["items"]] == [["a"]]


def test_an_output_folder_that_cannot_be_is_refused_in_one_line(tmp_path: Path):
    folder = sources(tmp_path / "one", "a")
    (tmp_path / "file").write_text("mine")
    for out in ("file", "file/library"):
        command = [*MANA, "assets", "ingest", str(folder), "--out", str(tmp_path / out)]
        refused = subprocess.run(command, capture_output=True, text=True, check=False)
        assert refused.returncode == 2
        [line] = refused.stderr.splitlines()
        assert str(tmp_path / out) in line
        assert not refused.stdout
    assert (tmp_path / "file").read_text() == "mine"
