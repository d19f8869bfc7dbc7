"""The numbered examples as a reader runs them: one after another as scripts, in one folder, with real results."""

from __future__ import annotations

import ast
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

import runtime_plan
from replay.verification.check_output import check_output, summary
from runtime_plan.verify import Judge
from schemas import AssetRecord, GapReport, ItemOutcome
from schemas.replay.documents import VARIANT_FILE, Variant
from tests.support.source_tree import PACKAGES, ROOT, parsed

EXAMPLES = tuple(sorted((ROOT / "examples").glob("0*.py")))
FEWEST_LINES, MOST_LINES = 20, 60  # an example is read in one sitting
JUDGED = 2000


def run(name: str, out: Path) -> str:
    """What the example prints; it must end without an error."""
    command = [sys.executable, str(ROOT / "examples" / name), str(out)]
    done = subprocess.run(command, cwd=out, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the examples share."""
    return tmp_path_factory.mktemp("examples")


@pytest.fixture(scope="module")
def library(out: Path) -> str:
    return run("01_ingest.py", out)


@pytest.fixture(scope="module")
def scene(out: Path, library: str) -> str:
    return run("02_compile.py", out)


@pytest.fixture(scope="module")
def drawn(out: Path, scene: str) -> str:
    return run("03_sample_in_training_loop.py", out)


@pytest.fixture(scope="module")
def augmented(out: Path, library: str) -> str:
    return run("04_augment.py", out)


@pytest.fixture(scope="module")
def gap(out: Path) -> str:
    return run("05_find_gap.py", out)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_uses_faces_alone(path: Path) -> None:
    """Modules below a package are not imported: what an example needs is on the face."""
    assert FEWEST_LINES <= len(path.read_text().splitlines()) <= MOST_LINES
    assert f"python examples/{path.name} OUT" in (ast.get_docstring(parsed(path)) or "")
    imports = [node for node in ast.walk(parsed(path)) if isinstance(node, ast.Import | ast.ImportFrom)]
    modules = {alias.name for node in imports if isinstance(node, ast.Import) for alias in node.names}
    modules |= {node.module or "" for node in imports if isinstance(node, ast.ImportFrom)}
    assert {module for module in modules if module.split(".")[0] in PACKAGES} <= {*PACKAGES}


def test_five_examples_are_numbered_from_one() -> None:
    assert [path.name.split("_")[0] for path in EXAMPLES] == ["01", "02", "03", "04", "05"]


def test_ingest_makes_packages_with_records(out: Path, library: str) -> None:
    records = {
        path.parent.name: AssetRecord.model_validate_json(path.read_bytes())
        for path in (out / "library").glob("*/record.json")
    }
    assert set(records) == {"mug", "tray_textured", "duck", "domino"}
    for name, record in records.items():
        assert record.outcome in (ItemOutcome.ACCEPTED, ItemOutcome.REPAIRED, ItemOutcome.REVIEW)
        assert (out / "library" / name / "usd" / f"{name}.usda").is_file()
        assert f"{name}: {record.physics.mass_kg.value:.3f} kg [" in library
    assert all(mesh in library for mesh in ("mug.obj: ", "tray_textured.obj: ", "duck.obj: ", "domino.obj: "))


def test_compile_writes_a_plan_whose_samples_are_valid(out: Path, scene: str) -> None:
    assert "tray_of_mugs: compiled" in scene
    assert (out / "scene" / "scene.usda").is_file()
    plan = runtime_plan.load(out / "scene" / "plan.json", packages=out / "library")
    assert plan.tables.names == ("tray", "mug_a", "mug_b", "mug_c")
    assert list(Judge(plan).violations(runtime_plan.sample(plan, JUDGED, 0))) == []


def test_compile_names_the_lines_that_conflict(scene: str) -> None:
    conflict = re.findall(r"^  three_cycle.yaml:(\d+) relations\[\d\]$", scene, re.MULTILINE)
    program = (ROOT / "examples" / "scenes" / "three_cycle.yaml").read_text().splitlines()
    assert "three_cycle: infeasible" in scene
    assert len(conflict) == 3
    assert all("of:" in program[int(line) - 1] for line in conflict)
    assert ": compiles" in scene


def test_resets_go_on_where_an_earlier_run_stopped(out: Path, drawn: str) -> None:
    """And scenes are what the plan gives, whatever the batches."""
    (count,) = re.findall(r"^(\d+) scenes drawn", drawn, re.MULTILINE)
    assert int(count) >= 1024
    assert {line.split(":")[0] for line in drawn.splitlines()[:-1]} == {"tray", "mug_a", "mug_b", "mug_c"}
    plan = runtime_plan.load(out / "scene" / "plan.json")
    resets = runpy.run_path(str(ROOT / "examples" / "03_sample_in_training_loop.py"))["Resets"]
    whole, first = runtime_plan.sample(plan, 30, 7), resets(plan, 7)
    batches = [first(np.arange(n)) for n in (3, 0, 17)]
    batches.append(resets(plan, 7, drawn=first.drawn)(np.arange(10)))
    np.testing.assert_array_equal(np.concatenate([batch.position_m for batch in batches]), whole.position_m)


def test_augmented_episodes_keep_their_states_and_their_distance(out: Path, augmented: str) -> None:
    folders = sorted(path.parent for path in (out / "augmented").rglob(VARIANT_FILE))
    assert [folder.name for folder in folders] == ["variant_0000", "variant_0001", "variant_0002"]
    source = pq.read_table(out / "episodes" / "wave" / "episode.parquet")
    for folder in folders:
        variant = Variant.model_validate_json((folder / VARIANT_FILE).read_bytes())
        assert len(variant.inserted) == 2
        assert all((out / "library" / (one.package or "") / "record.json").is_file() for one in variant.inserted)
        assert pq.read_table(folder / variant.recording / "episode.parquet").equals(source)
        assert f"{folder.name}: 2 new objects, least distance 0." in augmented
    checks = check_output(out / "augmented", out / "augmented" / "packages", None)
    totals = summary(checks)
    assert totals["variants"] == totals["sound"] == 3
    assert min(check.nearest.distance_m for check in checks if check.nearest is not None) >= 0.01
    assert augmented.count("recording unchanged") == 3


def test_the_gap_is_dry_friction_of_the_size_that_the_recordings_have(out: Path, gap: str) -> None:
    report = GapReport.model_validate(json.loads((out / "gap" / "report.json").read_text()))
    assert report.verdict.status == "effect_found"
    (effect,) = report.verdict.effects
    assert (effect.name, effect.where.joint) == ("joint.coulomb_friction", "door")
    torque_Nm = effect.parameters["torque_Nm"]
    assert torque_Nm.value == pytest.approx(0.008, rel=0.1)
    low_Nm, high_Nm = torque_Nm.ci95
    assert low_Nm <= 0.008 <= high_Nm
    assert gap.count("joint.coulomb_friction at door") == 2  # the statement, and its size
