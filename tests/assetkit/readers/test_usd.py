"""USD files: units, axes, default prim, articulation, and the shared files."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from pxr import Tf, Usd, UsdGeom

from assetkit.readers.usd import read_usd
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput
from tests.support.usd_files import model_of, read, rejection, write

# Unit, axis, default prim.


@pytest.mark.parametrize(
    ("header", "value", "source", "codes"),
    [
        ("metersPerUnit = 0.001", 0.001, "declared", []),
        ("metersPerUnit = 10", 10.0, "declared", []),
        ('doc = "nothing said"', 0.01, "declared", []),
    ],
)
def test_meters_per_unit(tmp_path: Path, header: str, value: float, source: str, codes: list[str]) -> None:
    outcome = read(write(tmp_path, 'def Cube "c" {}', header))
    assert outcome.value is not None
    assert (outcome.value.meters_per_unit.value, outcome.value.meters_per_unit.source) == (value, source)
    assert [d.code for d in outcome.diagnostics] == codes


def test_what_only_the_standard_implies_is_less_sure(tmp_path: Path) -> None:
    silent, stated = (read(write(tmp_path, 'def Cube "c" {}', h)).value for h in ('doc = "x"', "metersPerUnit = 0.01"))
    assert silent is not None
    assert stated is not None
    assert silent.meters_per_unit.confidence == silent.up_axis.confidence == 0.5
    assert stated.meters_per_unit.confidence == 1.0


@pytest.mark.parametrize(
    ("header", "operation", "values"),
    [
        ("metersPerUnit = 0.01", "", ["0.01"]),
        ('metersPerUnit = 1\n    upAxis = "Z"', "", ["Z"]),
        ('metersPerUnit = 1\n    upAxis = "Y"', "", []),
        ('doc = "silent"', "", []),
        ("metersPerUnit = 0.01", "double3 xformOp:scale:unitsResolve = (0.01, 0.01, 0.01)", []),
    ],
)
def test_a_layer_of_another_unit_is_noticed(tmp_path: Path, header: str, operation: str, values: list[str]) -> None:
    write(tmp_path, 'def Cube "c" {}', f'defaultPrim = "Root"\n    {header}').rename(tmp_path / "layer.usda")
    body = f'def "a" (references = @layer.usda@) {{ {operation} }}'
    outcome = read(write(tmp_path, body, 'metersPerUnit = 1\n    upAxis = "Y"'))
    found = [d for d in outcome.diagnostics if d.code == "asset/contradictory-evidence"]
    assert [d.value for d in found] == values
    assert all("layer.usda" in d.headline for d in found)


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf"])
def test_a_unit_that_is_no_length_is_rejected(tmp_path: Path, value: str) -> None:
    assert rejection(write(tmp_path, 'def Cube "c" {}', f"metersPerUnit = {value}")).code == "asset/invalid-unit-value"


def test_a_unit_of_the_wrong_type_is_used_and_repaired(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(stage: Usd.Stage) -> float:  # what OpenUSD does when an old exporter stored a single
        raise Tf.ErrorException("Requested type double for stage metadatum metersPerUnit")

    monkeypatch.setattr(UsdGeom, "GetStageMetersPerUnit", refuse)
    outcome = read(write(tmp_path, 'def Cube "c" {}', "metersPerUnit = 0.5"))
    assert outcome.value is not None
    assert outcome.value.meters_per_unit.value == 0.5
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/invalid-unit-value", "warning")]
    assert [r.name for r in outcome.repairs] == ["invalid_unit_value"]


@pytest.mark.parametrize(
    ("header", "axis", "source", "repairs"),
    [
        ('upAxis = "Y"', "y", "declared", []),
        ('upAxis = "Z"', "z", "declared", []),
        ('upAxis = "X"', "x", "inferred", ["invalid_up_axis"]),
        ('upAxis = "sideways"', "y", "default", ["invalid_up_axis"]),
        ("metersPerUnit = 1", "y", "declared", []),
    ],
)
def test_up_axis(tmp_path: Path, header: str, axis: str, source: str, repairs: list[str]) -> None:
    outcome = read(write(tmp_path, 'def Cube "c" {}', header))
    assert outcome.value is not None
    assert (outcome.value.up_axis.value, outcome.value.up_axis.source) == (axis, source)
    assert [r.name for r in outcome.repairs] == repairs


def test_the_default_prim_is_what_the_file_is_about(tmp_path: Path) -> None:
    both = '{}\n}}\ndef Sphere "Other" {{'
    assert len(model_of(write(tmp_path, both.format('def Cube "c" {}'))).meshes) == 1
    assert len(model_of(write(tmp_path, both.format('def Cube "c" {}'), 'upAxis = "Z"')).meshes) == 2
    absent = read(write(tmp_path, both.format('def Cube "c" {}'), 'defaultPrim = "Nobody"'))
    assert absent.value is not None
    assert len(absent.value.meshes) == 2
    assert [r.name for r in absent.repairs] == ["invalid_default_prim"]


def test_what_the_file_says_about_itself(tmp_path: Path) -> None:
    header = (
        'doc = "units are mm"\n customLayerData = {\n dictionary SimReady_Metadata = {\n string author = "Ada"\n }\n}'
    )
    root = 'def Xform "Root" (\n assetInfo = {\n string name = "Cup"\n string license = "CC0-1.0"\n }\n)'
    model = model_of(write(tmp_path, 'def Cube "c" {}', f'{header}\n defaultPrim = "Root"', root))
    assert model.metadata == {"author": "Ada", "license": "CC0-1.0", "title": "Cup"}
    assert "units are mm" in model.hints


# Articulation, and the shared files.


def test_joints_between_bodies_are_named(tmp_path: Path) -> None:
    body = """def Cube "a" {}\n def Cube "b" {}
      def PhysicsRevoluteJoint "hinge" { rel physics:body0 = </Root/a>\n rel physics:body1 = </Root/b>\n }"""
    (found,) = read(write(tmp_path, body)).diagnostics
    assert (found.code, found.severity, found.value) == ("asset/articulated-source", "warning", "/Root/hinge")
    fixed = body.replace("rel physics:body0 = </Root/a>\n", "")
    assert read(write(tmp_path, fixed)).diagnostics == ()


@pytest.mark.shared
def test_shared_assets_end_as_the_manifest_says(shared_assets: Path) -> None:
    with (shared_assets / "manifest.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["format"] in ("usd", "usdz")]
    assert len(rows) > 20
    for row in rows:
        path = shared_assets / row["path"]
        depth = 3 if row["path"].startswith("malformed") else 2
        source = SourceFile(path, shared_assets.joinpath(*Path(row["path"]).parts[:depth]))
        if row["outcome"] == "reject":
            with pytest.raises(InvalidInput) as caught:
                read_usd(source)
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        outcome = read_usd(source)
        assert outcome.value is not None, row["id"]
        assert bool(outcome.repairs) == (row["outcome"] == "repair"), row["id"]
        if row["meters_per_unit"]:
            assert outcome.value.meters_per_unit.value == float(row["meters_per_unit"]), row["id"]
            assert outcome.value.up_axis.value == row["up_axis"], row["id"]
        points = np.concatenate([mesh.points for mesh in outcome.value.meshes])
        measured = np.array([float(part) for part in row["measured_extent_native"].split("x")])
        # The measured boxes also count lights, and the boxes of rotated boxes.
        assert (np.ptp(points, axis=0) <= measured * (1 + 1e-4)).all(), row["id"]


@pytest.mark.shared
def test_reading_twice_gives_the_same_model(shared_assets: Path) -> None:
    path = shared_assets / "usd" / "uwg_teapot" / "Teapot.usd"
    first, second = (read_usd(SourceFile(path, path.parent)).value for _ in range(2))
    assert first is not None
    assert second is not None
    assert all(np.array_equal(a.points, b.points) for a, b in zip(first.meshes, second.meshes, strict=True))
    assert (first.materials, first.metadata, first.hints) == (second.materials, second.metadata, second.hints)
