"""What is known of a .blend file before Blender opens it, and what comes out where Blender is set up.

The first needs no Blender: the worker parses blocks, which any Python does. The second is skipped where it is absent.
"""

from __future__ import annotations

import gzip
import os
import struct
import sys
from pathlib import Path

import pytest

from assetkit.blender import environment
from assetkit.readers.blend.read import read_blend
from assetkit.sources.discover import discover
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput
from tests.conftest import SHARED
from tests.support.peers import needs_blender

NAME = b"LIother.blend\0".ljust(66, b"\0")


def block(code: bytes, data: bytes = b"") -> bytes:
    return struct.pack("<4siQii", code.ljust(4, b"\0"), len(data), 1, 0, 1) + data


def library(path: str) -> bytes:
    """A library block: its name, the path, and what a longer path of another machine left behind it."""
    return block(b"LI", NAME + path.encode().ljust(1024, b"\0") + b"C:\\old\\elsewhere.blend".ljust(1024, b"\0"))


def blend(*blocks: bytes, version: int = 293, end: bool = True) -> bytes:
    return b"BLENDER-v%03d" % version + b"".join(blocks) + (block(b"ENDB") if end else b"")


@pytest.fixture
def parser_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A complete environment without Blender: its Python is this one."""
    place = tmp_path / "environment"
    (place / "bin").mkdir(parents=True)
    (place / "bin" / "python").symlink_to(sys.executable)
    (place / environment.STAMP).write_text(environment.wanted_versions())
    monkeypatch.setenv(environment.VARIABLE, str(place))
    return place


def refusal(folder: Path, data: bytes, name: str = "part.blend") -> tuple[str, str]:
    file = folder / "in" / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(data)
    with pytest.raises(InvalidInput) as refused:
        read_blend(SourceFile(file, file.parent))
    return refused.value.diagnostic.code, str(refused.value.diagnostic.value)


def test_without_blender_the_user_is_told_what_to_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(environment.VARIABLE, str(tmp_path / "nowhere"))
    assert refusal(tmp_path, blend())[0] == "asset/blender-missing"


def test_an_environment_of_other_versions_or_cut_short_is_not_used(parser_only: Path):
    assert environment.python() == parser_only / "bin" / "python"
    (parser_only / environment.STAMP).write_text("of an earlier Mana")
    assert environment.python() is None
    (parser_only / environment.STAMP).unlink()
    assert environment.python() is None


@pytest.mark.parametrize("version", [247, 501])
def test_other_versions_are_refused_before_blender_opens_them(version: int, parser_only: Path, tmp_path: Path):
    assert refusal(tmp_path, blend(version=version)) == ("asset/blend-version", f"{version / 100:.2f}")


def test_the_header_of_version_5_is_read(parser_only: Path, tmp_path: Path):
    later = b"BLENDER17-01v0510" + struct.pack("<4siQqq", b"ENDB", 0, 0, 0, 0)
    assert refusal(tmp_path, later) == ("asset/blend-version", "5.10")


@pytest.mark.parametrize("packed", [bytes, gzip.compress])
def test_a_file_without_its_last_block_is_truncated(packed, parser_only: Path, tmp_path: Path):
    whole = blend(block(b"OB", bytes(500)))
    assert refusal(tmp_path, packed(whole[:-1]))[0] == "asset/truncated"
    assert refusal(tmp_path, packed(whole[:200]))[0] == "asset/truncated"
    assert refusal(tmp_path, packed(b"BLENDER-vxyz" + whole[12:]))[0] == "asset/wrong-content"


@pytest.mark.parametrize("path", ["//../outside.blend", "//..\\outside.blend", "/etc/outside.blend"])
def test_a_library_outside_of_the_folder_is_never_opened(path: str, parser_only: Path, tmp_path: Path):
    (tmp_path / "outside.blend").write_bytes(blend())
    assert refusal(tmp_path, blend(library(path)))[0] == "asset/path-escape"


def test_a_linked_library_is_a_part_of_the_file_that_links_to_it(tmp_path: Path):
    (tmp_path / "nodes").mkdir()
    (tmp_path / "scenes").mkdir()
    (tmp_path / "nodes" / "shared.blend").write_bytes(blend())
    (tmp_path / "scenes" / "cup.blend").write_bytes(blend(library("//..\\nodes\\shared.blend")))
    [found] = discover([tmp_path])
    assert (found.file.path.name, found.file.root) == ("cup.blend", tmp_path)


CASES = SHARED / "assets" / "malformed" / "blend"


@pytest.mark.shared
def test_scripts_in_a_file_never_run():
    needs_blender()
    folder = CASES / "gen_blend_autorun_script"
    before = sorted(os.listdir(folder))
    model = read_blend(SourceFile(folder / "part.blend", folder)).value
    assert model is not None
    assert sorted(os.listdir(folder)) == before
    assert model.triangle_count == 12


@pytest.mark.shared
def test_units_of_the_scene_are_declared_and_its_points_left_alone():
    needs_blender()
    folder = CASES / "gen_blend_unit_scale"
    model = read_blend(SourceFile(folder / "toolbox.blend", folder)).value
    assert model is not None
    assert (model.meters_per_unit.value, model.meters_per_unit.source, model.up_axis.value) == (0.01, "declared", "z")
    extent = model.meshes[0].points.max(axis=0) - model.meshes[0].points.min(axis=0)
    assert extent.tolist() == pytest.approx([42.0, 22.0, 20.0], rel=1e-5)
