"""`mana assets validate`: any file or folder, exit codes, JSON, and one bad file among many."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from assetkit.library.judge_file import validate_file
from assetkit.library.validate import main_usd_files, validate_files
from cli.main import app
from gate.external_validators import external_verdicts
from jobs.cell import Limits
from tests.support.gate_packages import cabinet, prop

FOREIGN = """#usda 1.0
(
    defaultPrim = "Box"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "Box" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
{
    def Cube "shape" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        double size = 0.1
    }
    def PhysicsFixedJoint "loose"
    {
    }
}
"""


def run(*arguments: str) -> tuple[int, dict]:
    result = CliRunner().invoke(app, ["assets", "validate", *arguments, "--json"])
    return result.exit_code, json.loads(result.stdout)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two clean packages and one whose door has inverted limits."""
    folder = tmp_path_factory.mktemp("library")
    prop(folder)
    main_file = cabinet(folder)
    broken = folder / "cabinet_broken" / "usd" / "cabinet_broken.usda"
    shutil.copytree(main_file.parent.parent, folder / "cabinet_broken")
    (broken.parent / main_file.name).rename(broken)
    broken.write_text(broken.read_text().replace("physics:upperLimit = 110", "physics:upperLimit = -110"))
    return folder


def test_a_library_is_judged_package_by_package(library: Path) -> None:
    code, found = run(str(library), "--gate-only")
    assert code == 1
    names = {Path(file).stem: [d["code"] for d in diagnostics] for file, diagnostics in found.items()}
    assert names["cabinet"] == names["sample-1"] == []
    assert "asset/gate-joint-limits" in names["cabinet_broken"]
    limits = next(d for f, ds in found.items() if "broken" in f for d in ds if d["code"] == "asset/gate-joint-limits")
    assert limits["where"]["prim"] == "/cabinet/Joints/hinge"
    assert (limits["value"], limits["bound"], limits["unit"]) == (0.0, -110.0, "deg")


def test_a_package_and_its_file_are_the_same(library: Path) -> None:
    package = library / "cabinet"
    assert (
        main_usd_files(package) == main_usd_files(package / "usd" / "cabinet.usda") == main_usd_files(package / "usd")
    )
    assert validate_file(package / "usd" / "cabinet.usda") == ()


def test_layers_of_an_asset_are_not_assets(tmp_path: Path) -> None:
    (tmp_path / "asset.usda").write_text("#usda 1.0\n(\n subLayers = [@./look.usda@]\n)\n")
    (tmp_path / "look.usda").write_text("#usda 1.0\n")
    (tmp_path / ".hidden.usda").write_text("#usda 1.0\n")
    assert main_usd_files(tmp_path) == [tmp_path / "asset.usda"]


def test_what_a_foreign_file_lacks_is_a_remark(tmp_path: Path) -> None:
    file = tmp_path / "box.usda"
    file.write_text(FOREIGN)
    found = validate_file(file)
    simready = {d.severity for d in found if d.code == "asset/simready-rule"}
    assert simready == {"info"}
    assert [d.severity for d in found] == sorted((d.severity for d in found), key=["error", "warning", "info"].index)
    joint = next(d for d in found if d.code == "asset/gate-joint-bodies")
    assert joint.where.prim == "/Box/loose"


def test_outside_validators_name_prims(tmp_path: Path) -> None:
    file = tmp_path / "box.usda"
    file.write_text(FOREIGN.replace("double size = 0.1", "rel material:binding = </gone>"))
    found = validate_file(file)
    assert any(d.code == "asset/usd-rule" and d.where.prim for d in found)
    assert any(d.code == "asset/simready-rule" and d.where.prim for d in found)
    assert all(str(tmp_path) not in d.headline for d in found)


def test_a_judge_that_fails_is_a_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: Path) -> None:
        raise RuntimeError("out of order")

    file = tmp_path / "box.usda"
    file.write_text(FOREIGN)
    monkeypatch.setattr("gate.external_validators.VALIDATORS", (("simready", fails),))
    (verdict,) = external_verdicts(file)
    assert not verdict.passed
    assert "out of order" in verdict.findings[0].message


def test_a_file_that_takes_too_long_costs_itself_only(library: Path) -> None:
    file = library / "cabinet" / "usd" / "cabinet.usda"
    ((_, found),) = validate_files([file], limits=Limits(seconds=0.01))
    assert [d.code for d in found] == ["asset/worker-timeout"]


def test_an_archive_that_climbs_out_is_not_opened(tmp_path: Path) -> None:
    file = tmp_path / "slip.usdz"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("../evil.usda", "#usda 1.0\n")
    assert [d.code for d in validate_file(file)] == ["asset/path-escape"]


def test_nothing_to_judge_is_exit_code_2(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["assets", "validate", str(tmp_path / "gone")]).exit_code == 2
    with pytest.raises(FileNotFoundError):  # `cli.main.run` turns it into exit code 2.
        CliRunner().invoke(app, ["assets", "validate", str(tmp_path)], catch_exceptions=False)


def test_the_text_groups_by_severity(library: Path) -> None:
    shown = CliRunner().invoke(app, ["assets", "validate", str(library / "cabinet_broken"), "--gate-only"]).stdout
    assert "errors (wrong)" in shown
    assert shown.index("/cabinet/Joints/hinge") > shown.index("errors (wrong)")
