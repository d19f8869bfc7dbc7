"""What is drawn passes the independent judge; what is moved by hand does not."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.main import app
from runtime_plan import prepare, sample
from runtime_plan.verify import Judge
from tests.support.plan.library import grid_plan, tray_plan

GRID, TRAY = grid_plan(30, 60), tray_plan()


@pytest.mark.parametrize("document", [GRID, TRAY], ids=["grid", "tray"])
def test_samples_are_valid(document):
    plan = prepare(document)
    assert list(Judge(plan).violations(sample(plan, 4000, 9))) == []


def test_a_moved_thing_is_found_with_its_index():
    plan = prepare(GRID)
    drawn = sample(plan, 100, 1, start=50)
    drawn.position_m[7, 3, :2] = drawn.position_m[7, 4, :2]
    drawn.position_m[20, 0, 2] += 0.01
    found = list(Judge(plan).violations(drawn))
    assert {row["index"] for row in found} == {57, 70}
    assert {row["kind"] for row in found if row["index"] == 70} == {"unsupported"}
    assert any(set(row["things"]) == {"thing3", "thing4"} for row in found)


def test_tilted_missing_and_wrongly_owned_things_are_found():
    plan = prepare(TRAY)
    drawn = sample(plan, 60, 2)
    cup, plate = drawn.names.index("cup"), drawn.names.index("plate")
    drawn.quat_wxyz[0, cup] = (0.9999, 0.01, 0.0, 0.0)
    drawn.present[1, cup] = False
    drawn.support[2, cup] = plate
    first = next(k for k in range(3, 60) if not drawn.present[k, plate])
    drawn.present[first, plate] = True
    kinds = {row["index"]: row["kind"] for row in Judge(plan).violations(drawn)}
    assert kinds == {0: "stance", 1: "missing", 2: "support", first: "extra"}


def test_the_command_reports_as_designed(tmp_path: Path):
    path, out = tmp_path / "plan.json", tmp_path / "samples.json"
    path.write_text(TRAY.model_dump_json())
    run = CliRunner().invoke(app, ["plan", "verify", str(path), "--n", "500", "--seed", "3", "--json"])
    assert run.exit_code == 0
    assert json.loads(run.stdout) == {"checked": 500, "invalid": 0, "violations": []}
    CliRunner().invoke(app, ["plan", "sample", str(path), "--n", "8", "--out", str(out)], catch_exceptions=False)
    document = json.loads(out.read_text())
    document["samples"][5]["objects"]["cup"]["position_m"][0] += 0.5
    out.write_text(json.dumps(document))
    run = CliRunner().invoke(app, ["plan", "verify", str(path), "--samples", str(out), "--json"])
    assert run.exit_code == 1
    report = json.loads(run.stdout)
    assert (report["checked"], report["invalid"]) == (8, 1)
    assert {row["index"] for row in report["violations"]} == {5}


def test_any_number_of_processes_gives_the_same_report(tmp_path: Path):
    broken = GRID.combinations[0].pools[0].cases[0]
    cells = (broken.cells_um[1], *broken.cells_um[1:])  # two boxes in one cell
    pool = GRID.combinations[0].pools[0]
    case = broken.model_copy(update={"cells_um": cells, "yaws_urad": (((0, 0),), *broken.yaws_urad[1:])})
    one = GRID.combinations[0].model_copy(
        update={"pools": (pool.model_copy(update={"cases": (case, *pool.cases[1:])}),)}
    )
    path = tmp_path / "plan.json"
    path.write_text(GRID.model_copy(update={"combinations": (one,)}).model_dump_json())
    asked = ["plan", "verify", str(path), "--n", "9000", "--json"]
    runs = [CliRunner().invoke(app, [*asked, "--jobs", jobs]) for jobs in ("1", "2")]
    assert runs[0].stdout == runs[1].stdout
    assert json.loads(runs[0].stdout)["invalid"] > 50
    assert np.isfinite(json.loads(runs[0].stdout)["violations"][0]["value"])
