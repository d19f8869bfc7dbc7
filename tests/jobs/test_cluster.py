"""Cells on a real cluster: a scheduler and workers as processes of their own, which join late, die and differ."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from jobs import cluster as jobs_cluster
from jobs.cell import Limits, allow_cells, kill_all_cells
from jobs.cluster import cluster_cells, unsuitable
from jobs.placement import ClusterUnusable
from jobs.schedule import run_all
from jobs.warm import run_module

LIMITS = Limits(60.0, 4096)
CELL = """
import os, sys, time
what, *rest = sys.argv[1:]
if what == 'say': print(*rest)
if what == 'abort': os.abort()
if what == 'hang':
    with open(rest[0], 'a') as file: print(os.getpid(), rest[1], file=file)
    while not os.path.exists(rest[2]): time.sleep(0.05)
    print('released')
"""
DRIVER = """
import sys
from pathlib import Path
from jobs.cell import Limits
from jobs.cluster import cluster_cells
from jobs.warm import run_module
if __name__ == '__main__':
    with cluster_cells(sys.argv[1], 'json', shared=[], env={}, jobs=1):
        run_module('a_cell', ['hang', *sys.argv[2:]], Limits(60.0, 4096))
"""


class Processes:
    """A scheduler and the workers that the tests add to it, each in a session of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}
        self.running: list[subprocess.Popen[bytes]] = []
        self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        wait_until(self.file.is_file)

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    @property
    def address(self) -> str:
        return json.loads(self.file.read_text())["address"]

    def start(self, what: str, *options: str, extra_path: Path | None = None) -> subprocess.Popen[bytes]:
        env = dict(self.env)
        if extra_path is not None:
            env["PYTHONPATH"] = os.pathsep.join([str(extra_path), env["PYTHONPATH"]])
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + what, "--scheduler-file", str(self.file), *options],
            env=env,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.running.append(process)
        return process

    def worker(self, extra_path: Path | None = None) -> subprocess.Popen[bytes]:
        return self.start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", extra_path=extra_path)

    def end(self) -> None:
        for process in self.running:
            kill(process)


def kill(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.05)


def lines(file: Path) -> list[list[str]]:
    return [line.split() for line in file.read_text().splitlines()] if file.is_file() else []


def alive(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    (tmp_path / "a_cell.py").write_text(CELL)
    started = Processes(tmp_path)
    yield started
    started.end()
    allow_cells()


def test_a_killed_worker_a_late_one_and_a_stranger_cost_nothing(processes: Processes, tmp_path: Path):
    """The item of a killed worker is run again by one that joined late; a worker with another numpy gets none."""
    (tmp_path / "other" / "numpy-9.9.dist-info").mkdir(parents=True)
    (tmp_path / "other" / "numpy-9.9.dist-info" / "METADATA").write_text("Name: numpy\nVersion: 9.9\n")
    first = processes.worker()
    log, release = tmp_path / "log", tmp_path / "release"
    answers: dict[int, str] = {}
    with cluster_cells(processes.address, "json", shared=[tmp_path], env={}, jobs=1) as cluster:
        assert run_module("a_cell", ["say", "hello"], LIMITS).output == "hello\n"
        assert run_module("a_cell", ["abort"], LIMITS).status == "crashed"

        def work(n: int) -> str:
            return run_module("a_cell", ["hang", str(log), str(n), str(release)], LIMITS).output

        def drive() -> None:
            answers.update(run_all(work, range(4), jobs=lambda: cluster.capacity))

        driver = threading.Thread(target=drive)
        driver.start()
        wait_until(lambda: lines(log))
        processes.worker(extra_path=tmp_path / "other")
        wait_until(lambda: cluster.refused)
        assert "numpy 9.9 instead of" in next(iter(cluster.refused.values()))
        [[pid, item]] = lines(log)
        kill(first)
        wait_until(lambda: not alive(pid))  # The cell dies with its worker.
        processes.worker()
        wait_until(lambda: len(lines(log)) > 1)
        assert lines(log)[1][1] == item
        release.touch()
        driver.join(30.0)
    assert answers == dict.fromkeys(range(4), "released\n")
    assert not list(tmp_path.glob(".probe-*"))


def test_cells_end_when_nobody_waits_for_them(processes: Processes, tmp_path: Path):
    """After Ctrl-C, and when the driver is killed."""
    processes.worker()
    log, release = tmp_path / "log", tmp_path / "never"
    with cluster_cells(processes.address, "json", shared=[], env={}, jobs=1):
        stopped: list[str] = []
        hang = ["hang", str(log), "0", str(release)]
        waiting = threading.Thread(target=lambda: stopped.append(run_module("a_cell", hang, LIMITS).status))
        waiting.start()
        wait_until(lambda: lines(log))
        kill_all_cells()
        waiting.join(30.0)
        assert stopped == ["cancelled"]
        wait_until(lambda: not alive(lines(log)[0][0]))
    allow_cells()
    (tmp_path / "driver.py").write_text(DRIVER)
    arguments = [processes.address, str(log), "1", str(release)]
    driver = subprocess.Popen(
        [sys.executable, str(tmp_path / "driver.py"), *arguments], env=processes.env, start_new_session=True
    )
    wait_until(lambda: len(lines(log)) == 2)
    kill(driver)
    wait_until(lambda: not alive(lines(log)[1][0]))


def test_a_cluster_that_cannot_be_used_says_why(processes: Processes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(jobs_cluster, "CONNECT_TIMEOUT_S", 2.0)
    (tmp_path / "other" / "scipy-0.1.dist-info").mkdir(parents=True)
    (tmp_path / "other" / "scipy-0.1.dist-info" / "METADATA").write_text("Name: scipy\nVersion: 0.1\n")
    processes.worker(extra_path=tmp_path / "other")
    with (
        pytest.raises(ClusterUnusable, match=r"no worker .* is suitable; .*scipy 0\.1 instead of"),
        cluster_cells(processes.address, "json", shared=[], env={}, jobs=1),
    ):
        pass
    with (
        pytest.raises(ClusterUnusable, match="does not answer"),
        cluster_cells("127.0.0.1:1", "json", shared=[], env={}, jobs=1),
    ):
        pass


def test_a_worker_that_does_not_share_the_folder_is_unsuitable(tmp_path: Path):
    from jobs.cluster import _versions

    (tmp_path / "probe").write_text("token")
    assert unsuitable(_versions(), {str(tmp_path / "probe"): "token"}) == ""
    assert "shared" not in unsuitable(_versions(), {}) == ""
    for file in (tmp_path / "absent" / "probe", tmp_path / "probe"):
        assert f"does not see the folder {file.parent}" in unsuitable(_versions(), {str(file): "another token"})
