"""The lock of a folder: one holder, named to others, gone with its process."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.lock import LOCK, FolderInUse, FolderUnusable, exclusive

HOLD = """
import sys, time
from pathlib import Path
from jobs.lock import exclusive
with exclusive(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


def holder(folder: Path) -> subprocess.Popen[str]:
    """A process that holds the lock of `folder`."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_second_process_is_refused_at_once_and_the_holder_is_named(tmp_path: Path):
    folder = tmp_path / "library"
    process = holder(folder)
    try:
        with pytest.raises(FolderInUse) as refused, exclusive(folder):
            pytest.fail("two holders")
        assert str(folder) in str(refused.value)
        assert f"process {process.pid};" in str(refused.value)
        assert "\n" not in str(refused.value)
        assert (folder / LOCK).read_text().startswith(f"{process.pid} ")
    finally:
        process.kill()
        process.wait()


def test_a_killed_holder_leaves_no_stale_lock(tmp_path: Path):
    process = holder(tmp_path)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert (tmp_path / LOCK).exists()
    with exclusive(tmp_path):
        assert (tmp_path / LOCK).read_text().startswith(f"{os.getpid()} ")
    assert not (tmp_path / LOCK).exists()


def test_children_do_not_inherit_the_lock(tmp_path: Path):
    with exclusive(tmp_path):
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], close_fds=False)
    try:
        with exclusive(tmp_path):
            pass
    finally:
        child.kill()
        child.wait()


def test_a_folder_made_for_nothing_is_removed_and_a_full_one_stays(tmp_path: Path):
    with exclusive(tmp_path / "empty"):
        assert (tmp_path / "empty").is_dir()
    assert not (tmp_path / "empty").exists()
    with exclusive(tmp_path / "full"):
        (tmp_path / "full" / "a").touch()
    assert (tmp_path / "full" / "a").exists()


@pytest.mark.parametrize("below", ["file", "file/library"])
def test_what_is_no_folder_is_refused_in_one_line(tmp_path: Path, below: str):
    (tmp_path / "file").touch()
    with pytest.raises(FolderUnusable, match="not a folder") as refused, exclusive(tmp_path / below):
        pytest.fail("locked a file")
    assert "\n" not in str(refused.value)


def test_a_lock_on_a_file_that_the_holder_removed_is_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The holder before removes the file after it was opened here, and before it is locked."""
    lock = fcntl.flock

    def removed_first(descriptor: int, operation: int) -> None:
        monkeypatch.setattr(fcntl, "flock", lock)
        (tmp_path / LOCK).unlink()
        lock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", removed_first)
    with exclusive(tmp_path):
        assert (tmp_path / LOCK).exists()
        with pytest.raises(FolderInUse), exclusive(tmp_path):
            pytest.fail("two holders")


def test_many_processes_in_turn_never_hold_it_together(tmp_path: Path):
    """The lock file is removed and made anew again and again: whoever opened the old one looks again."""
    script = """
import sys, time
from pathlib import Path
from jobs.lock import FolderInUse, exclusive
folder, inside, done = Path(sys.argv[1]), Path(sys.argv[1]) / "inside", 0
while done < 50:
    try:
        with exclusive(folder):
            inside.touch(exist_ok=False)
            inside.unlink()
            done += 1
    except FolderInUse:
        time.sleep(0.001)
"""
    processes = [subprocess.Popen([sys.executable, "-c", script, str(tmp_path)]) for _ in range(4)]
    assert [p.wait(timeout=60) for p in processes] == [0, 0, 0, 0]
