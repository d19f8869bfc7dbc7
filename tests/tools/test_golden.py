"""The comparison of recordings: what counts as a difference, what does not, and how it is reported."""

from __future__ import annotations

import json
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from PIL import Image

from tools.golden.__main__ import compare, main
from tools.golden.cases import GROUPS, PACKAGES, Place, all_cases
from tools.golden.differences import Comparison, Difference
from tools.golden.run import REPO, record

CASE = "assets/case"
Write = Callable[[Path], object]


def recording(folder: Path, name: str, write: Write | None, case: str = CASE, **more: object) -> Path:
    """A recording with one case of one file; `run` is its temporary folder."""
    out = folder / "outputs" / case
    out.mkdir(parents=True)
    if write is not None:
        write(out / name)
    manifest = {"cases": {case: 1.0}, "left_out": {}, "roots": {"run": f"/tmp/{folder.name}"}} | more
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def compared(tmp_path: Path, name: str, old: Write | None, new: Write | None, case: str = CASE) -> Comparison:
    return compare(recording(tmp_path / "a", name, old, case), recording(tmp_path / "b", name, new, case), [])


def only(differing: Comparison, name: str, case: str = CASE) -> list[Difference]:
    """Differences of the one file that differs."""
    assert list(differing.differing) == [f"{case}/{name}"]
    return differing.differing[f"{case}/{name}"]


def as_json(value: object) -> Write:
    return lambda path: path.write_text(json.dumps(value))


def as_text(text: str) -> Write:
    return lambda path: path.write_text(text)


def picture(pixels: np.ndarray, level: int = 6) -> Write:
    return lambda path: Image.fromarray(pixels).save(path, compress_level=level)


def test_a_number_is_reported_with_its_path_and_difference(tmp_path: Path):
    old, new = {"physics": {"mass_kg": [{"value": 1.0}]}}, {"physics": {"mass_kg": [{"value": 1.0 + 1e-12}]}}
    (found,) = only(compared(tmp_path, "record.json", as_json(old), as_json(new)), "record.json")
    assert (found.kind, found.where, found.old) == ("number", "$.physics.mass_kg[0].value", "1.0")
    assert found.most == pytest.approx(1e-12, rel=1e-3)


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ({"a": "left"}, {"a": "right"}, "words"),
        ({"a": 1}, {"a": 1.0}, "structure"),
        ({"a": 1}, {"a": True}, "structure"),
        ({"a": 1}, {"a": None}, "structure"),
        ({"a": [1, 2]}, {"a": [1]}, "structure"),
        ({"a": 1}, {}, "missing"),
        ({}, {"a": 1}, "extra"),
        ({"key": "left"}, {"key": "right"}, "words"),  # no digest
        ({"schema_version": "1.0"}, {"schema_version": "1.1"}, "words"),
        ({"hashes": {"a": "0" * 64}}, {"hashes": {"a": "1" * 64}}, "words"),  # of bytes
    ],
)
def test_every_other_change_of_json_is_reported(tmp_path: Path, old: object, new: object, kind: str):
    (found,) = only(compared(tmp_path, "a.json", as_json(old), as_json(new)), "a.json")
    assert found.kind == kind


def test_seconds_versions_cache_keys_and_paths_are_no_difference(tmp_path: Path):
    def of(run: str, digit: str, number: float) -> object:
        return {
            "seconds": {"intake": number},
            "totals": {"wall_seconds": number, "intake_seconds": number, "packages": 4},
            "history": [{"name": "intake", "version": number, "key": digit * 16}],
            "bodies": [{"package_hash": digit * 64}],
            "out": f"/tmp/{run}/library",
        }

    found = compared(tmp_path, "report.json", as_json(of("a", "1", 1.5)), as_json(of("b", "2", 2.5)))
    assert found.equal
    assert found.same_content == [f"{CASE}/report.json"]


def test_texts_are_compared_by_line_without_the_seconds_they_took(tmp_path: Path):
    name, old = "a.txt", "v 1 2 3\ninfeasible: there is no such scene (0.02 s)\nin /tmp/a/x\n"
    new = old.replace("0.02 s", "1.5 s").replace("/tmp/a", "/tmp/b")
    assert compared(tmp_path / "same", name, as_text(old), as_text(new)).equal
    (number,) = only(compared(tmp_path / "number", name, as_text(old), as_text(new.replace("2 3", "2.5 3"))), name)
    assert (number.kind, number.where, number.most) == ("number", "line 1", 0.5)
    (word,) = only(compared(tmp_path / "word", name, as_text(old), as_text(new.replace("no such", "one"))), name)
    assert (word.kind, word.where) == ("words", "line 2")
    longer = only(compared(tmp_path / "longer", name, as_text(old), as_text(f"{new}end\n")), name)
    assert [(one.kind, one.where) for one in longer] == [("structure", "number of lines"), ("words", "line 4")]


def test_seconds_of_a_run_in_a_page_are_no_difference(tmp_path: Path):
    old = '<div class="line">4 packages in 4.5 s</div><span class="time">1.2 s</span>'
    new = old.replace("4.5", "12").replace("1.2", "0.3")
    assert compared(tmp_path, "a.html", as_text(old), as_text(new)).equal


def test_physical_seconds_in_a_text_are_compared(tmp_path: Path):
    found = compared(tmp_path, "a.html", as_text("<p>period 0.20 s of j0</p>"), as_text("<p>period 0.21 s of j0</p>"))
    assert only(found, "a.html")[0].most == pytest.approx(0.01)


def test_pictures_are_compared_by_pixels(tmp_path: Path):
    old = np.zeros((10, 10, 3), np.uint8)
    new = old.copy()
    new[3, 4, 1] = 7
    assert compared(tmp_path / "same", "a.png", picture(old), picture(old, level=0)).equal
    (found,) = only(compared(tmp_path / "other", "a.png", picture(old), picture(new)), "a.png")
    assert (found.kind, found.new, found.most) == ("pixels", "1 % of the pixels differ", 7.0)
    deep = np.full((4, 4), 60000, np.uint16)
    assert not compared(tmp_path / "deep", "a.png", picture(deep), picture(deep + np.uint16(1))).equal
    assert not compared(tmp_path / "size", "a.png", picture(old), picture(old[:5])).equal


def test_a_file_of_one_side_only_is_reported(tmp_path: Path):
    write = as_text("a")
    assert [one.kind for one in only(compared(tmp_path / "missing", "a.txt", write, None), "a.txt")] == ["missing"]
    assert [one.kind for one in only(compared(tmp_path / "extra", "a.txt", None, write), "a.txt")] == ["extra"]


@pytest.mark.parametrize("suffix", ["npz", "npy", "parquet", "h5"])
def test_arrays_are_compared_by_content(tmp_path: Path, suffix: str):
    def of(values: np.ndarray, size: int) -> Write:
        def write(path: Path) -> None:
            if suffix == "npz":
                (np.savez if size else np.savez_compressed)(path, q=values)
            elif suffix == "npy":
                np.save(path, values)
            elif suffix == "parquet":
                pq.write_table(pa.table({"q": values}), path, compression="none" if size else "snappy")
            else:
                with h5py.File(path, "w", userblock_size=512 * size) as file:
                    file["q"] = values

        return write

    values, name = np.array([1.0, np.nan, 3.0]), f"a.{suffix}"
    assert compared(tmp_path / "same", name, of(values, 0), of(values.copy(), 1)).equal
    (found,) = only(compared(tmp_path / "other", name, of(values, 0), of(values + np.array([0.0, 0.0, 0.5]), 0)), name)
    assert (found.kind, found.most) == ("number", 0.5)
    assert "1 of 3 values" in found.where


def test_attributes_of_hdf5_are_compared(tmp_path: Path):
    def of(model: str) -> Write:
        def write(path: Path) -> None:
            with h5py.File(path, "w") as file:
                file.create_dataset("data", data=1.0).attrs["model"] = model

        return write

    assert not compared(tmp_path, "a.hdf5", of("<a/>"), of("<b/>")).equal


def test_rows_of_a_database_are_compared(tmp_path: Path):
    def of(mass: float, names: tuple[str, ...]) -> Write:
        def write(path: Path) -> None:
            base = sqlite3.connect(path)
            base.execute("create table assets (name text, mass real)")
            base.execute("create virtual table words using fts5 (names)")
            base.executemany("insert into assets values (?, ?)", [(name, mass) for name in names])
            base.commit()
            base.close()

        return write

    assert compared(tmp_path / "same", "a.sqlite", of(1.0, ("cup", "mug")), of(1.0, ("mug", "cup"))).equal
    (found, _) = only(
        compared(tmp_path / "other", "a.sqlite", of(1.0, ("cup", "mug")), of(2.0, ("cup", "mug"))), "a.sqlite"
    )
    assert (found.kind, found.where) == ("number", "$.assets[0][1]")


def test_binary_usd_is_compared_as_text(tmp_path: Path):
    created = "import sys; from pxr import Sdf\nlayer = Sdf.Layer.CreateAnonymous('.usdc')\n"
    created += "assert layer.ImportFromString(sys.argv[2]) and layer.Export(sys.argv[1])"

    def of(size: float) -> Write:
        text = f'#usda 1.0\ndef Cube "a" {{\n  double size = {size}\n}}\n'
        return lambda path: subprocess.run([sys.executable, "-c", created, str(path), text], check=True)

    (found,) = only(compared(tmp_path, "a.usdc", of(1.0), of(1.5)), "a.usdc")
    assert (found.kind, found.most) == ("number", 0.5)


def test_names_of_schemas_do_not_count_but_their_content_does(tmp_path: Path):
    def of(name: str, kind: str, title: str) -> object:
        return {
            "title": title,
            "properties": {"title": {"$ref": f"#/$defs/{name}"}},
            "$defs": {name: {"title": name, "type": kind, "items": {"$ref": f"#/$defs/{name}"}}},
        }

    case, old = "schemas/all", as_json(of("Part", "array", "Model"))
    assert compared(tmp_path / "same", "a.json", old, as_json(of("Piece", "array", "Body")), case).equal
    other = compared(tmp_path / "other", "a.json", old, as_json(of("Part", "object", "Model")), case)
    assert [one.where for one in only(other, "a.json", case)] == ["$.$defs.0.type"]
    gone = as_json({"title": "Model", "properties": {}})
    assert not compared(tmp_path / "gone", "a.json", old, gone, case).equal  # a property may be called title


def test_cases_of_one_recording_only_are_named_and_not_called_equal(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    old = recording(tmp_path / "a", "a.txt", as_text("a"), cases={CASE: 1.0, "gap/more": 1.0})
    new = recording(tmp_path / "b", "a.txt", as_text("a"), left_out={"gap/more": "needs the shared data"})
    assert compare(old, new, []).not_compared == {"gap/more": "needs the shared data"}
    assert compare(old, new, ["assets"]).not_compared == {}
    assert main(["compare", str(old), "--against", str(new)]) == 0
    assert "not compared: gap/more (needs the shared data)" in capsys.readouterr().out


def test_the_command_prints_what_differs_and_ends_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    old = recording(tmp_path / "a", "a.json", as_json({"x": 1.5}))
    new = recording(tmp_path / "b", "a.json", as_json({"x": 2.0}))
    assert main(["compare", str(old), "--against", str(new)]) == 1
    assert "$.x [number]: 1.5 -> 2.0 (by 0.5)" in capsys.readouterr().out
    assert main(["compare", str(old), "--against", str(new), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["differing"][f"{CASE}/a.json"][0]["most"] == 0.5
    assert main(["compare", str(tmp_path), "--against", str(new)]) == 2


def test_equal_differences_are_written_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folders = [recording(tmp_path / name, "a.json", as_json({"x": x})) for name, x in (("a", 1.5), ("b", 2.0))]
    for folder, x in zip(folders, (1.5, 2.0), strict=True):
        as_json({"x": x})(folder / "outputs" / CASE / "b.json")
    assert main(["compare", str(folders[0]), "--against", str(folders[1])]) == 1
    assert f"{CASE}/b.json: as {CASE}/a.json" in capsys.readouterr().out


def test_the_set_is_what_was_agreed(tmp_path: Path, bullet_data: Path):
    cases = all_cases()
    names = [case.name for case in cases]
    assert len(set(names)) == len(names)
    assert {case.group for case in cases} == set(GROUPS)
    assert {case.after for case in cases} == {None, PACKAGES}
    assert len([name for name in names if name.startswith("scenes/")]) >= 6
    assert len([case for case in cases if case.group == "gap" and not case.shared]) >= 4
    sources: set[Path] = set()
    for case in (case for case in cases if case.group == "assets" and not case.shared):
        made = tmp_path / case.name
        made.mkdir(parents=True)
        place = Place(REPO, tmp_path / "out", made, tmp_path / "library", bullet_data, None)
        ingested = [one for one in case.steps(place) if one.args[:2] == ("assets", "ingest")]
        given = [Path(word) for one in ingested for word in one.args[2:]]
        files = [file for path in given for file in (path, *path.rglob("*")) if file.is_file()]
        sources |= {file.relative_to(made) if file.is_relative_to(made) else file for file in files}
    assert len(sources) >= 12
    assert len({source.suffix.lower() for source in sources}) >= 7


def test_a_run_stores_its_outputs_and_never_replaces_another_folder(tmp_path: Path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.tex").write_text("")
    with pytest.raises(FileExistsError):
        record(tmp_path / "other", ["docs"], None, print)
    for _ in range(2):  # a recording may be replaced
        manifest = record(tmp_path / "new", ["docs"], None, print)
        assert list(manifest.cases) == ["docs/pages"]
        assert (tmp_path / "new" / "outputs" / "docs" / "pages" / "diagnostics" / "index.md").is_file()
