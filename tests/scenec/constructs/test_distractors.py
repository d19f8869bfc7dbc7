"""Distractors: number and assets vary over draws, files lack absent ones, the task and the evaluation share none."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.main import app
from runtime_plan import Restriction, load, restrict
from runtime_plan.plan import Plan, prepare
from runtime_plan.sampler import sample
from runtime_plan.samples_file import as_document
from runtime_plan.verify import Judge
from scenec.compile import Compiled, compile_program
from tests.support.scene import library as scene_library
from usdio.reread.scene import reread_scene

PROGRAM = (Path(__file__).parents[2] / "data" / "scenes" / "distractors.yaml").read_text()
CLUTTER = ["clutter-1", "clutter-2", "clutter-3"]


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene_library.library(tmp_path_factory.mktemp("library"), cubes=1)


def compiled_from(folder: Path, packages: Path, text: str = PROGRAM, diversity: float | None = None) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", packages, diversity=diversity)


@pytest.fixture(scope="module")
def plan(packages: Path, tmp_path_factory: pytest.TempPathFactory) -> Plan:
    compiled = compiled_from(tmp_path_factory.mktemp("program"), packages, diversity=0.1)
    assert compiled.plan is not None
    return prepare(compiled.plan)


def test_the_scene_holds_the_most_of_them(packages: Path, tmp_path: Path):
    (scene,) = compiled_from(tmp_path, packages).scenes
    assert [p.id for p in scene.objects if "distractor" in p.semantic_tags] == CLUTTER


def test_numbers_and_assets_vary_and_every_draw_is_valid(plan: Plan):
    samples = sample(plan, 3000, 7)
    columns = [samples.names.index(name) for name in CLUTTER]
    present = samples.present[:, columns]
    assert np.abs(np.bincount(present.sum(axis=1), minlength=4)[1:] / 3000 - 1 / 3).max() < 0.04
    assert np.ptp(present.mean(axis=0)) < 0.05
    assert len(np.unique(samples.asset_index[:, columns][present])) == 2
    assert np.isnan(samples.position_m[:, columns][~present]).all()
    assert (samples.asset_index[:, columns][~present] == -1).all()
    assert list(Judge(plan).violations(sample(plan, 400, 3))) == []


def test_any_split_of_the_draws_gives_the_same(plan: Plan):
    whole, part = sample(plan, 700, 7), sample(plan, 100, 7, start=600)
    np.testing.assert_array_equal(whole.present[600:], part.present)


def test_files_leave_absent_ones_out(plan: Plan):
    samples = sample(plan, 50, 7)
    for k, scene in enumerate(as_document(plan, samples).samples):
        there = [name for name, is_there in zip(samples.names, samples.present[k], strict=True) if is_there]
        assert sorted(scene.objects) == sorted(there)


def test_the_judge_counts_them_and_judges_those_that_are_there(plan: Plan):
    samples = sample(plan, 200, 7)
    columns = [samples.names.index(name) for name in CLUTTER]
    alone = int(np.flatnonzero(samples.present[:, columns].sum(axis=1) == 1)[0])
    (column,) = [c for c in columns if samples.present[alone, c]]
    present, moved = samples.present.copy(), samples.position_m.copy()
    present[alone, column] = False
    assert "count" in [row["kind"] for row in Judge(plan).violations(replace(samples, present=present))]
    moved[alone, column] = moved[alone, samples.names.index("mug")]
    kinds = {row["kind"] for row in Judge(plan).violations(replace(samples, position_m=moved))}
    assert kinds & {"penetration", "range"}


def test_a_restriction_to_a_split_leaves_assets_of_the_pool_out(plan: Plan):
    only = restrict(plan, Restriction(assets=dict.fromkeys(CLUTTER, ("cube",))))
    samples = sample(only, 100, 7)
    index = samples.asset_index[:, [samples.names.index(name) for name in CLUTTER]]
    assert {plan.document.bodies[b].asset_id for b in np.unique(index[index >= 0])} == {"cube"}


@pytest.mark.parametrize(
    ("old", "new", "codes"),
    [
        ("pool: [cube, bin]", "pool: [cube, mug]", ["scene/distractor-overlap"]),
        ("eval: [tried]", "eval: [bin]", ["scene/distractor-overlap", "scene/split-overlap"]),
        ("[mug, plate]}", "[clutter-2, plate]}", ["scene/distractor-named"]),
        ("count: [1, 3]", "count: [3, 1]", ["scene/range-reversed"]),
        ("id: clutter", "id: mug", ["scene/duplicate-id"]),
        ("surface: tabletop, ranges", "surface: shelf, ranges", ["scene/missing-anchor"]),
        ("pool: [cube, bin]", "pool: [cube, cub]", ["scene/unknown-asset"]),
    ],
)
def test_distractors_are_checked_where_they_are_written(
    old: str, new: str, codes: list[str], packages: Path, tmp_path: Path
):
    diagnostics = compiled_from(tmp_path, packages, PROGRAM.replace(old, new)).report.diagnostics
    assert {d.code for d in diagnostics} <= set(codes)
    assert diagnostics[0].code == codes[0]
    assert diagnostics[0].where.line in (12, 14)


def test_a_stage_of_a_draw_lacks_the_absent_ones(packages: Path, tmp_path: Path):
    (tmp_path / "program.yaml").write_text(PROGRAM)
    out = tmp_path / "out"
    options = ["--assets", str(packages), "--out", str(out), "--no-settle", "--no-pictures"]
    run = CliRunner().invoke(app, ["scene", "compile", str(tmp_path / "program.yaml"), *options])
    assert run.exit_code == 0, run.output
    run = CliRunner().invoke(app, ["plan", "realise", str(out / "plan.json"), "--n", "6", "--json"])
    assert run.exit_code == 0, run.output
    files = [Path(name) for name in json.loads(run.stdout)["files"]]
    samples = sample(load(out / "plan.json"), 6, 0)
    assert not samples.present.all()
    for k, file in enumerate(files):
        there = {name for name, is_there in zip(samples.names, samples.present[k], strict=True) if is_there}
        assert {body.name for body in reread_scene(file)} - {"background"} == there
