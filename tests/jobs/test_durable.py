"""What was written is flushed before its name appears, and two folders change places in one step."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from assetkit.package import release
from jobs import durable
from jobs.cache import changed_files, write_atomically
from jobs.durable import exchange, sync_tree
from tests.assetkit.test_batch import package


def test_exchange_swaps_two_folders(tmp_path: Path):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / name).touch()
    if exchange(tmp_path / "one", tmp_path / "other"):
        assert [p.relative_to(tmp_path).as_posix() for p in sorted(tmp_path.glob("*/*"))] == ["one/other", "other/one"]
        with pytest.raises(OSError, match="No such file"):
            exchange(tmp_path / "one", tmp_path / "absent")


def test_all_files_of_a_tree_are_flushed_and_then_their_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a" / "b").mkdir(parents=True)
    for name in ("a/x", "a/b/y", "a/b/z"):
        (tmp_path / name).write_text(name)
    flushed: list[str] = []
    monkeypatch.setattr(os, "fsync", lambda fd: flushed.append(os.readlink(f"/proc/self/fd/{fd}")))
    sync_tree(tmp_path / "a")
    names = [Path(path).relative_to(tmp_path).as_posix() for path in flushed]
    assert sorted(names) == ["a", "a/b", "a/b/y", "a/b/z", "a/x"]
    assert names.index("a/b") > max(names.index("a/b/y"), names.index("a/b/z"))
    assert names[-1] == "a"


def test_a_package_is_flushed_before_its_name_appears(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    seen: list[bool] = []
    monkeypatch.setattr(release, "sync_tree", lambda folder: seen.append((tmp_path / "mug").exists()))
    release.publish(package(tmp_path, "mug"), tmp_path / "mug")
    assert seen == [False]
    assert (tmp_path / "mug").exists()


@pytest.mark.parametrize("swaps", [True, False], ids=["in one step", "in two steps"])
def test_a_package_that_is_replaced_is_never_a_part(swaps: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A reader beside it sees the old package or the new one; where the file system can swap, one of them always."""
    if not swaps:
        monkeypatch.setattr(durable, "_LIBC", None)
    release.publish(package(tmp_path, "mug"), tmp_path / "mug")
    (tmp_path / "probe").mkdir()
    swaps = exchange(tmp_path / "probe", tmp_path / "mug") and exchange(tmp_path / "probe", tmp_path / "mug")
    parts, absent, done = [0], [0], threading.Event()

    def read() -> None:
        while not done.is_set():
            folder = (tmp_path / "mug").exists()
            absent[0] += not folder
            parts[0] += folder and not (tmp_path / "mug" / "record.json").exists() and (tmp_path / "mug").exists()

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(60):
        assert release.publish(package(tmp_path, "mug"), tmp_path / "mug") is None
    done.set()
    reader.join()
    assert parts == [0] or not swaps
    assert absent == [0] or not swaps
    assert not list(tmp_path.glob(".mug.old"))


def test_a_file_that_cannot_be_written_whole_does_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(path: Path, data: bytes) -> int:
        with path.open("wb") as file:
            file.write(data[:1])
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space"):
        write_atomically(tmp_path / "note.json", b"{}")
    assert list(tmp_path.iterdir()) == []


def test_hashes_of_files_outside_of_a_folder_are_not_computed(tmp_path: Path):
    (tmp_path / "secret").write_text("x")
    (tmp_path / "package").mkdir()
    names = ["../secret", str(tmp_path / "secret"), "a/../../secret"]
    assert changed_files(tmp_path / "package", dict.fromkeys(names, "0" * 64)) == names
