"""`mana assets accept`: exit codes, JSON, suites and roles by name, packages that do not affect each other."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pxr import Sdf, Usd, UsdGeom, UsdPhysics
from typer.testing import CliRunner, Result

from assetkit.library.accept import accept_files
from assetkit.library.acceptance_request import AcceptanceRequest
from cli.assets.app import app
from cli.engines import SIMULATOR
from jobs.cell import Limits


def run(*words: str) -> Result:
    return CliRunner().invoke(app, ["accept", *words], env={"COLUMNS": "200", "TERM": "dumb"})


def read(*words: str) -> tuple[int, dict[str, Any]]:
    """Exit code and the reports by the name of their package; strict JSON, without NaN or Infinity."""
    done = run(*words, "--json")

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    reports = json.loads(done.stdout, parse_constant=refuse)
    return done.exit_code, {Path(file).parents[1].name: report for file, report in reports.items()}


def turn_inside_out(file: Path) -> None:
    """Reverse the winding of the colliders of a package."""
    layer = Sdf.Layer.FindOrOpen(str(file.parent / "payloads" / f"{file.stem}_physics.usda"))
    stage = Usd.Stage.Open(layer)
    for prim in stage.Traverse():
        if prim.HasAPI(UsdPhysics.CollisionAPI) and prim.IsA(UsdGeom.Mesh):
            indices = UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr()
            indices.Set(np.asarray(indices.Get()).reshape(-1, 3)[:, ::-1].ravel().tolist())
    layer.Save()


def outcomes(report: dict[str, Any]) -> dict[str, str]:
    return {suite["name"]: suite["outcome"] for suite in report["suites"]}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wedge as it is released, and one whose hull was turned inside out since."""
    folder = tmp_path_factory.mktemp("wedges")
    block = folder / "block.stl"
    foot = [(x, y, 0.0) for x in (-0.03, 0.03) for y in (-0.025, 0.025)]
    ridge = [(-0.03, y, 0.04) for y in (-0.025, 0.025)]
    trimesh.convex.convex_hull(np.array([*foot, *ridge])).export(block)
    words = ["--out", str(folder / "library"), "--units", "m", "--up-axis", "z", "--role", "manipulated"]
    ingested = CliRunner().invoke(app, ["ingest", str(block), *words])
    assert ingested.exit_code == 0, ingested.output
    shutil.copytree(folder / "library" / "block", folder / "library" / "reversed")
    turn_inside_out(folder / "library" / "reversed" / "usd" / "block.usda")
    return folder / "library"


def test_a_library_has_a_report_per_package_in_json_also_of_infinite_figures(library: Path) -> None:
    code, reports = read(str(library), "--role", "manipulated", "--quick")
    assert code == 1
    assert list(reports) == ["block", "reversed"]
    good, bad = reports["block"], reports["reversed"]
    assert good["roles"] == ["manipulated"]
    assert list(outcomes(good)) == ["gate", "object", "on_record", "common", "manipulated"]
    assert set(outcomes(good).values()) == {"passed"}
    assert outcomes(bad)["object"] == "failed"
    assert outcomes(bad)["on_record"] == outcomes(bad)["manipulated"] == "not_run"
    checks = [check for suite in bad["suites"] for check in suite["checks"]]
    assert "Infinity" in [check["value"] for check in checks]
    assert "asset/package-invalid" in [finding["code"] for finding in bad["findings"]]


def test_roles_are_exercised_also_where_the_object_fails_but_can_be_simulated(library: Path, tmp_path: Path) -> None:
    shutil.copytree(library / "block", tmp_path / "block")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "block" / "usd" / "payloads" / "block_physics.usda"))
    stage = Usd.Stage.Open(layer)
    hull = next(prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI))
    points = UsdGeom.Mesh(hull).GetPointsAttr()
    points.Set((np.asarray(points.Get()) * [1.4, 1.0, 1.0]).tolist())
    layer.Save()
    code, reports = read(str(tmp_path / "block"), "--quick")
    assert (code, outcomes(reports["block"])["object"]) == (1, "failed")
    assert outcomes(reports["block"])["manipulated"] != "not_run"


def test_only_the_suites_that_are_named_run_and_quick_leaves_other_conditions_out(library: Path) -> None:
    file = library / "block" / "usd" / "block.usda"
    code, reports = read(str(file), "--suite", "common", "--suite", "object")
    assert (code, outcomes(reports["block"])) == (0, {"object": "passed", "common": "passed"})
    done = run(str(file), "--suite", "object")
    assert done.exit_code == 0
    assert "passed   object" in done.stdout
    assert "common" not in done.stdout


@pytest.mark.long
def test_only_thorough_runs_have_repeats(library: Path) -> None:
    words = (str(library / "block"), "--suite", "manipulated", "--role", "manipulated")
    (slow,), (quick,) = (read(*words)[1]["block"]["suites"], read(*words, "--quick")[1]["block"]["suites"])
    assert (len(slow["repeats"]) > 0, len(quick["repeats"])) == (True, 0)
    assert slow["checks"] == quick["checks"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--suite", "manipulate"], "must be one of gate, object, on_record, common"),
        (["--role", "mug"], "must be one of"),
        (["--video", "out.gif"], "has 2 packages; a video shows one"),
    ],
)
def test_mistakes_are_refused_with_exit_code_2(words: list[str], message: str, library: Path) -> None:
    done = run(str(library), *words)
    assert done.exit_code == 2
    assert message in done.output


def test_a_path_that_does_not_exist_is_refused_with_exit_code_2(tmp_path: Path) -> None:
    assert run(str(tmp_path / "gone")).exit_code == 2


def test_usd_of_another_maker_in_centimetres_is_exercised_and_assumptions_are_named(tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "brick.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Brick").GetPrim())
    body = UsdGeom.Xform.Define(stage, "/Brick/body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    UsdPhysics.MassAPI.Apply(body).CreateMassAttr(0.2)
    cube = UsdGeom.Cube.Define(stage, "/Brick/body/cube")
    cube.CreateSizeAttr(4.0)
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    stage.Save()
    code, reports = read(str(tmp_path / "brick.usda"), "--role", "manipulated", "--quick", "--suite", "manipulated")
    (report,) = reports.values()
    assert (code, outcomes(report)) == (0, {"manipulated": "passed"})
    severities = {finding["headline"]: finding["severity"] for finding in report["findings"]}
    assert [level for words, level in severities.items() if "friction 0.5" in words] == ["warning"]
    assert [level for words, level in severities.items() if "0.01 m" in words] == ["info"]
    assert [level for words, level in severities.items() if "Y is up" in words] == ["info"]


def test_what_cannot_be_exercised_fails_with_a_code(tmp_path: Path) -> None:
    shutil.copy(Path(__file__), tmp_path / "broken.usda")
    code, reports = read(str(tmp_path / "broken.usda"))
    assert code == 1
    assert [finding["code"] for finding in next(iter(reports.values()))["findings"]] == ["asset/package-invalid"]


@pytest.mark.parametrize(
    ("engine", "code"),
    [
        ("os:abort", "asset/worker-crashed"),
        pytest.param("signal:pause", "asset/worker-timeout", marks=pytest.mark.long),
    ],
)
def test_an_engine_that_crashes_or_hangs_on_a_package_affects_no_other(engine: str, code: str, library: Path) -> None:
    files = sorted(library.glob("*/usd/*.usda"))
    requests = [
        AcceptanceRequest(main_file=str(file), engine=used, suites=("object",))
        for file, used in zip(reversed(files), (engine, SIMULATOR), strict=True)
    ]
    lost, good = (report for _, report in accept_files(requests, limits=Limits(seconds=10.0)))
    assert [finding.code for finding in lost.findings] == [code]
    assert not lost.passed
    assert np.all([check.passed for suite in good.suites for check in suite.checks])
    assert good.passed
