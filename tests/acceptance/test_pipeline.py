"""Real files through the whole command, as a user would run it."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange.stl import export_stl_ascii

from schemas.asset import AssetRecord
from tests.support.bad_inputs.assets import SAMPLES, gltf, obj_text

MANA = (sys.executable, "-m", "cli.main")


def mana(*arguments: str | Path, expect: int = 0) -> str:
    done = subprocess.run([*MANA, *map(str, arguments)], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == expect, done.stdout + done.stderr
    return done.stdout


def tree_hash(folder: Path) -> dict[str, str]:
    return {
        p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in sorted(folder.rglob("*"))
        if p.is_file()
    }


def record_of(package: Path) -> AssetRecord:
    return AssetRecord.model_validate_json((package / "record.json").read_bytes())


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory, bullet_data: Path) -> tuple[Path, dict]:
    """A cup as OBJ, a cube as glTF, a textured duck, a ring in millimetres, and two files that must be refused."""
    base = tmp_path_factory.mktemp("run")
    sources = base / "in"
    sources.mkdir()
    cup = trimesh.creation.revolve(
        np.array([[0, 0], [0.04, 0], [0.04, 0.09], [0.036, 0.09], [0.036, 0.005], [0, 0.005]])
    )
    (sources / "cup.obj").write_text(obj_text(cup))
    gltf()(sources)
    ring = trimesh.creation.annulus(r_min=12, r_max=20, height=10)
    (sources / "ring.stl").write_bytes(export_stl_ascii(ring).replace("solid", "solid units: mm", 1).encode())
    SAMPLES["asset/truncated"](sources)
    SAMPLES["asset/path-escape"](sources)
    duck = base / "duck"
    duck.mkdir()
    for name in ("duck.dae", "duckCM.png"):
        target = duck / ("images" if name.endswith("png") else "") / name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes((bullet_data / name).read_bytes())
    out = base / "library"
    report = json.loads(
        mana("assets", "ingest", sources, duck / "duck.dae", "--out", out, "--jobs", "2", "--json", expect=1)
    )
    return out, report


def test_every_source_has_a_row_and_the_right_end(library: tuple[Path, dict]):
    _, report = library
    ends = {Path(i["source"]).name: i["outcome"] for i in report["items"]}
    assert ends == {
        "cup.obj": "accepted",
        "part.gltf": "accepted",
        "duck.dae": "accepted",
        "ring.stl": "repaired",
        "part.glb": "rejected",
        "part.obj": "rejected",
    }
    repairs = {r["name"] for i in report["items"] for r in i["repairs"]}
    assert "unit_mm" in repairs


def test_packages_pass_the_outside_judges(library: tuple[Path, dict]):
    out, report = library
    assert sum(len(i["packages"]) for i in report["items"]) == 4
    verdicts = json.loads(mana("assets", "validate", out, "--json"))
    assert len(verdicts) == 4
    assert not [d for found in verdicts.values() for d in found if d["severity"] == "error"]


def test_the_cup_keeps_its_cavity_and_its_frame(library: tuple[Path, dict]):
    out, _ = library
    record = record_of(out / "cup")
    x, y, z = record.geometry.extent_m.value
    assert (x, y, z) == pytest.approx((0.08, 0.08, 0.09), rel=0.01)
    chosen = next(c for c in record.physics.candidates if c.accepted)
    assert chosen.cavity_kept
    assert chosen.shapes > 1
    volume = np.pi * (0.04**2 * 0.09 - 0.036**2 * 0.085)
    assert record.geometry.volume_m3.value == pytest.approx(volume, rel=0.02)
    assert (record.semantics.category.value, record.semantics.category.source) == ("cup", "inferred")
    assert "receptacle" in [r.value for r in record.semantics.roles]


def test_units_and_truth_of_the_ring(library: tuple[Path, dict]):
    record = record_of(library[0] / "ring")
    assert record.geometry.extent_m.value == pytest.approx((0.04, 0.04, 0.01), rel=0.01)
    assert record.source.meters_per_unit.source == "inferred"


def test_urdf_twin_has_the_same_mass(library: tuple[Path, dict]):
    for package in ("cup", "duck"):
        record = record_of(library[0] / package)
        mass = ET.parse(next((library[0] / package / "export").glob("*.urdf"))).find(".//mass")
        assert mass is not None
        assert float(mass.attrib["value"]) == pytest.approx(record.physics.mass_kg.value, rel=1e-5)


def test_the_texture_of_the_duck_survives_byte_for_byte(library: tuple[Path, dict], bullet_data: Path):
    wanted = hashlib.sha256((bullet_data / "duckCM.png").read_bytes()).hexdigest()
    assert wanted in tree_hash(library[0] / "duck").values()


def test_previews_and_report_are_there(library: tuple[Path, dict]):
    out, _ = library
    for package in ("cup", "duck", "ring"):
        names = {p.stem for p in (out / package / "previews").glob("*.png")}
        assert {"thumbnail", "collision"} <= names
        assert len(names - {"grasps"}) == 6  # one more where something can be grasped
    assert '"cup"' in (out / "report.html").read_text()
    page = (out / ".report" / "00000.js").read_text()
    assert "cup/previews/thumbnail.png" in page
    assert "asset/path-escape" in page


def test_nothing_in_a_package_tells_when_or_where_it_was_made(library: tuple[Path, dict]):
    out, _ = library
    for path in (p for p in (out / "cup").rglob("*") if p.suffix in {".usda", ".json", ".urdf"}):
        text = path.read_text()
        assert str(out) not in text
        assert str(out.parent) not in text
    assert json.loads((out / "cup" / "record.json").read_text())["schema_version"]


def test_same_bytes_for_any_process_count_and_a_fresh_folder(library: tuple[Path, dict], tmp_path: Path):
    first, _ = library
    sources = first.parent / "in"
    out = tmp_path / "again"
    mana("assets", "ingest", sources, first.parent / "duck" / "duck.dae", "--out", out, "--jobs", "1", expect=1)
    for package in ("cup", "duck", "ring"):
        assert tree_hash(first / package) == tree_hash(out / package)


def test_second_run_takes_everything_from_the_store(library: tuple[Path, dict]):
    out, first = library
    sources = out.parent / "in"
    before = {p: tree_hash(out / p) for p in ("cup", "ring")}
    again = json.loads(
        mana("assets", "ingest", sources, out.parent / "duck" / "duck.dae", "--out", out, "--json", expect=1)
    )
    assert again["totals"]["cached"] == len(first["items"])
    assert {p: tree_hash(out / p) for p in ("cup", "ring")} == before


def test_a_damaged_package_is_made_again(library: tuple[Path, dict]):
    out, _ = library
    (out / "ring" / "previews" / "thumbnail.png").write_bytes(b"damaged")
    again = json.loads(mana("assets", "ingest", out.parent / "in", "--out", out, "--json", expect=1))
    remade = [Path(i["source"]).name for i in again["items"] if i["cached"] != ["item"]]
    assert remade == ["ring.stl"]
    assert (out / "ring" / "previews" / "thumbnail.png").read_bytes()[:4] == b"\x89PNG"


def test_list_search_and_show(library: tuple[Path, dict]):
    out, _ = library
    assert {r["asset_id"] for r in json.loads(mana("assets", "list", out, "--json"))} >= {"cup", "ring", "duck"}
    assert [r["asset_id"] for r in json.loads(mana("assets", "search", "duck", "--in", out, "--json"))["hits"]] == [
        "duck"
    ]
    assert "mass_kg" in mana("assets", "show", out / "cup")


def test_render_pictures_a_package_and_a_source(library: tuple[Path, dict], tmp_path: Path):
    out, _ = library
    for source in (out / "cup", out.parent / "in" / "cup.obj"):
        pictures = json.loads(mana("assets", "render", source, "--out", tmp_path / source.name, "--json"))
        assert all(Path(p).read_bytes()[:4] == b"\x89PNG" for p in pictures)
        assert len(pictures) >= 5


def test_validate_judges_foreign_files_without_falling_over(tmp_path: Path):
    """The smallest stage whose metersPerUnit has the wrong value type: OpenUSD's own getter raises on it."""
    foreign = tmp_path / "foreign.usda"
    foreign.write_text('#usda 1.0\n(\n    metersPerUnit = "one"\n)\ndef Xform "a" {}\n')
    found = json.loads(mana("assets", "validate", foreign, "--json", expect=1))
    assert "asset/package-invalid" in {d["code"] for d in found[str(foreign)]}


def test_up_axis_licence_and_role_of_the_user_reach_the_record(tmp_path: Path):
    (tmp_path / "post.obj").write_text(obj_text(trimesh.creation.box((0.1, 0.5, 0.1))))
    flags = ("--up-axis", "y", "--license", "CC0-1.0", "--author", "Jane", "--role", "manipulated", "--category", "box")
    mana("assets", "ingest", tmp_path / "post.obj", "--out", tmp_path / "out", *flags)
    record = record_of(tmp_path / "out" / "post")
    assert record.geometry.extent_m.value == pytest.approx((0.1, 0.1, 0.5))
    assert record.source.up_axis.source == "declared"
    assert (record.source.license.value, record.source.license.source) == ("CC0-1.0", "declared")
    assert record.source.author.value == "Jane"
    assert record.semantics.category.value == "box"
    assert [r.value for r in record.semantics.roles] == ["manipulated"]


def test_missing_source_is_exit_code_two(tmp_path: Path):
    mana("assets", "ingest", tmp_path / "none.obj", "--out", tmp_path / "out", expect=2)


def test_schema_is_valid_json_schema(library: tuple[Path, dict]):
    import jsonschema

    schema = json.loads(mana("schema", "asset"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(json.loads((library[0] / "cup" / "record.json").read_text()), schema)


def test_help_teaches():
    assert "Example" in mana("assets", "ingest", "--help")
