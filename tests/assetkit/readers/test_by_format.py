"""One table of formats: folder walks, names in texts, first bytes, readers and habits of units follow from its rows."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from assetkit.options import Options
from assetkit.readers import by_format
from assetkit.readers.by_format import CAD_FORMATS, FORMAT_OF, FORMATS, READERS
from assetkit.readers.common.sniff import screen, sniff
from assetkit.readers.source_format import SourceFormat
from assetkit.scale.unit_posterior import unit_prior
from assetkit.sources.discover import discover, format_of
from assetkit.stages.intake import ReadSource
from schemas.diagnostics import InvalidInput, Location
from tests.support.present import present

EACH = pytest.mark.parametrize("row", FORMATS, ids=lambda row: row.name)


def test_names_and_extensions_belong_to_one_format():
    assert len(READERS) == len(FORMATS)
    assert len(FORMAT_OF) == sum(len(row.extensions) for row in FORMATS)
    assert all(e == e.lower() and e.startswith(".") for e in FORMAT_OF)


@EACH
def test_a_walk_takes_every_extension_and_a_text_that_names_one_makes_it_a_part(row: SourceFormat, tmp_path: Path):
    for extension in row.extensions:
        folder = tmp_path / extension[1:]
        folder.mkdir()
        (folder / f"thing{extension}").write_text(dict(row.marks).get(extension, ""))
        assert [asset.format for asset in discover([folder])] == [row.name]
        assert format_of(Path(f"THING{extension.upper()}")) == row.name
        (folder / "robot.urdf").write_text(f'<mesh filename="thing{extension}"/>')
        assert [asset.file.path.name for asset in discover([folder])] == ["robot.urdf"]


@EACH
def test_text_formats_that_name_files_take_them_as_parts(row: SourceFormat, tmp_path: Path):
    for extension in row.referring:
        (tmp_path / "part.stl").write_bytes(b"")
        (tmp_path / f"whole{extension}").write_text(dict(row.marks).get(extension, "") + ' "part.stl"')
        assert [asset.file.path.name for asset in discover([tmp_path])] == [f"whole{extension}"]
        (tmp_path / f"whole{extension}").unlink()


@EACH
def test_first_bytes_name_the_format_and_are_refused_elsewhere(row: SourceFormat):
    for signature in row.magic:
        known = present(sniff(signature.first_bytes))
        assert known == (signature.content, signature.extensions or row.extensions)
        assert set(known[1]) <= set(row.extensions)
        screen(signature.first_bytes, known[1][0][1:], where=Location())
        with pytest.raises(InvalidInput, match=signature.content):
            screen(signature.first_bytes, "stl", where=Location())


def test_only_formats_of_cad_are_presumed_to_be_in_millimetres():
    assert {"stl"} == CAD_FORMATS
    millimetres = {row.name: unit_prior(row.name, ())["mm"] for row in FORMATS}
    assert {name for name, share in millimetres.items() if share > 0.5} == CAD_FORMATS


def test_a_row_that_is_missing_takes_its_format_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "thing.ply").write_bytes(b"ply\n")
    rows = tuple(row for row in FORMATS if row.name != "ply")
    monkeypatch.setattr(by_format, "FORMATS", rows)
    assert sniff(b"ply\n") is None
    monkeypatch.setattr("assetkit.stages.intake.READERS", {row.name: row.read for row in rows})
    (asset,) = discover([tmp_path / "thing.ply"])
    assert [d.code for d in ReadSource().run(asset, Options()).diagnostics] == ["asset/format-unsupported"]


def test_the_table_loads_no_library_of_a_reader():
    """Discovery runs in the command line's own process, which starts in a fraction of a second."""
    heavy = "{'scipy', 'pxr', 'lxml', 'DracoPy', 'PIL', 'networkx'}"
    code = f"import sys, assetkit.sources.discover; print(*sorted({heavy} & set(sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout.split() == []
