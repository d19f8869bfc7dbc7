"""A range of table heights: every draw of the range is valid, everything rises together, readers of draws follow."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.main import app
from runtime_plan import as_document, load, prepare, read_samples, sample
from runtime_plan.cameras import bodies_of
from runtime_plan.plan import Plan
from runtime_plan.realise import Realiser
from runtime_plan.verify import Judge
from scenec.compile import Compiled, compile_program
from sim.bullet.resets import BulletResets
from sim.bullet.world import private_client
from usdio.reread.scene import reread_scene

PROGRAM = (Path(__file__).parents[2] / "data" / "scenes" / "table_height.yaml").read_text()
LOWEST_TOP_M = 0.02 + 0.6 + 0.05


def compiled_from(folder: Path, text: str = PROGRAM) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", diversity=0.1)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    compiled = compiled_from(tmp_path_factory.mktemp("height"))
    assert compiled.plan is not None
    return prepare(compiled.plan)


def test_draws_cover_the_range_and_everything_rises_together(plan: Plan):
    samples = sample(plan, 400, 5)
    assert samples.rise_m.min() < 0.01
    assert 0.14 < samples.rise_m.max() <= 0.15
    np.testing.assert_allclose(samples.position_m[:, :, 2], LOWEST_TOP_M + samples.rise_m[:, None] + np.zeros((1, 2)))
    tops = [max(p.high_m for p in bodies_of(plan, samples, k)["background"].prisms) for k in range(20)]
    np.testing.assert_allclose(tops, LOWEST_TOP_M + samples.rise_m[:20])
    assert list(Judge(plan).violations(samples)) == []
    np.testing.assert_array_equal(sample(plan, 10, 5, start=390).rise_m, samples.rise_m[390:])


def test_the_judge_refuses_a_table_beyond_its_range_and_a_cup_that_did_not_rise(plan: Plan):
    samples = sample(plan, 1, 5)
    higher = replace(
        samples, rise_m=np.array([0.2]), position_m=samples.position_m + np.array([0.0, 0.0, 0.2 - samples.rise_m[0]])
    )
    assert [row["kind"] for row in Judge(plan).violations(higher)] == ["height"]
    left = samples.position_m.copy()
    left[0, 0, 2] -= samples.rise_m[0]
    assert {row["kind"] for row in Judge(plan).violations(replace(samples, position_m=left))} == {"owner_entered"}


def test_files_and_simulators_follow(plan: Plan, tmp_path: Path):
    samples = sample(plan, 4, 5)
    (tmp_path / "samples.json").write_text(as_document(plan, samples).model_dump_json())
    _, read = read_samples(tmp_path / "samples.json", plan)
    np.testing.assert_allclose(read.rise_m, samples.rise_m)
    assert list(Judge(plan).violations(read)) == []
    with private_client() as client:
        world = BulletResets(client)
        realiser = Realiser(plan, None, world)
        for k in range(4):
            realiser.reset(samples, k)


def test_the_stage_of_a_draw_has_the_table_at_its_height(tmp_path: Path):
    (tmp_path / "program.yaml").write_text(PROGRAM)
    out = tmp_path / "out"
    options = ["--out", str(out), "--no-settle", "--no-pictures"]
    run = CliRunner().invoke(app, ["scene", "compile", str(tmp_path / "program.yaml"), *options])
    assert run.exit_code == 0, run.output
    run = CliRunner().invoke(app, ["plan", "realise", str(out / "plan.json"), "--n", "3", "--json"])
    assert run.exit_code == 0, run.output
    samples = sample(load(out / "plan.json"), 3, 0)
    for k, name in enumerate(json.loads(run.stdout)["files"]):
        bodies = {body.name: body.X_WA for body in reread_scene(Path(name))}
        assert bodies["background"][2, 3] == pytest.approx(0.62 + samples.rise_m[k])
        assert bodies["a"][2, 3] == pytest.approx(LOWEST_TOP_M + samples.rise_m[k])


def test_a_reversed_range_is_an_error(tmp_path: Path):
    (diagnostic,) = compiled_from(tmp_path, PROGRAM.replace("[0.6, 0.75]", "[0.8, 0.75]")).report.diagnostics
    assert diagnostic.code == "scene/range-reversed"
    assert diagnostic.where.line == 2
