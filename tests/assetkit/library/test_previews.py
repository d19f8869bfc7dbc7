"""Previews are drawn in a cell and refused files are reported."""

from pathlib import Path

import pytest

from assetkit.batch.item_cells import DEFAULT_LIMITS
from assetkit.library.previews import pictures
from jobs.cell import Limits
from schemas.diagnostics import InvalidInput
from tests.support.bad_inputs.assets import CUBE, obj_text


def refusal(path: Path, out: Path, limits: Limits = DEFAULT_LIMITS) -> str:
    with pytest.raises(InvalidInput) as caught:
        pictures(path, out, ("beauty",), limits=limits)
    return caught.value.diagnostic.code


def test_a_readable_file_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    Path("part.obj").write_text(obj_text(CUBE))
    written = pictures(Path("part.obj"), Path("out"), ("beauty", "wire"))
    assert written
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in written)


def test_what_the_readers_refuse_comes_back_as_they_say_it(tmp_path: Path):
    (tmp_path / "part.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert refusal(tmp_path / "part.obj", tmp_path) == "asset/nonfinite-vertices"


def test_a_file_that_takes_its_reader_down_does_no_more_than_that(tmp_path: Path):
    (tmp_path / "part.obj").write_text(obj_text(CUBE))
    assert refusal(tmp_path / "part.obj", tmp_path, Limits(seconds=0.05, memory_mb=8192)) == "asset/worker-timeout"


def test_a_folder_without_usd_is_the_users_mistake(tmp_path: Path):
    with pytest.raises(FileNotFoundError):
        pictures(tmp_path, tmp_path, ("beauty",))
