"""Stacks: each thing stands on the one below, draws balance, what may fall is refused, the judge sees fallen ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime_plan.plan import prepare
from runtime_plan.verify import Judge
from scenec.compile import Compiled, compile_program
from tests.support.scene.drawn import drawn

PROGRAM = """\
background: {asset: {type: box, size_m: [0.6, 0.6, 0.05]}}
anchors: {tabletop: {object: background}}
objects: [{id: brick, asset: {type: box, size_m: [0.1, 0.1, 0.04]}}, {id: ball, asset: {type: sphere, radius_m: 0.03}}]
layout:
  nodes: {brick: {object: brick}, ball: {object: ball}}
  groups:
    tower: {type: stack, members: [brick], count: 5, surface: tabletop, alignment: 0.008, turn_deg: [-15, 15]}
    alone: {type: stack, members: [ball], surface: tabletop}
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return compiled_from(tmp_path_factory.mktemp("stack"), PROGRAM)


def compiled_from(folder: Path, text: str) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", diversity=0.05)


def test_each_thing_stands_on_the_one_below(compiled: Compiled):
    (scene,) = compiled.scenes
    owner = {placed.id: placed.parent for placed in scene.objects}
    assert [owner[f"brick-{k}"] for k in range(1, 6)] == ["background", *(f"brick-{k}" for k in range(1, 5))]
    heights = [next(p for p in scene.objects if p.id == f"brick-{k}").position_m[2] for k in range(1, 6)]
    np.testing.assert_allclose(heights, 0.05 + 0.04 * np.arange(5), atol=1e-9)


def test_draws_use_the_alignment_and_the_turns(compiled: Compiled):
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 400)
    columns = [samples.names.index(f"brick-{k}") for k in range(1, 6)]
    place = samples.position_m[:, columns, :2]
    assert 0.0075 < np.abs(np.diff(place, axis=1)).max() < 0.008 * np.sqrt(2.0) + 1e-9
    assert 14.0 < np.degrees(np.abs(samples.yaw_rad[:, columns[1:]]).max()) <= 15.0 + 1e-6
    assert list(Judge(prepare(compiled.plan)).violations(samples)) == []


@pytest.mark.parametrize("number", [2, 5])
def test_the_judge_refuses_a_brick_that_hangs_over_too_far(compiled: Compiled, number: int):
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 1)
    column = samples.names.index(f"brick-{number}")
    moved = samples.position_m.copy()
    moved[0, column:, 0] += 0.06
    rows = list(Judge(prepare(compiled.plan)).violations(replace(samples, position_m=moved)))
    assert ("unsupported", [f"brick-{number}", f"brick-{number - 1}"]) in [(row["kind"], row["things"]) for row in rows]


def test_the_judge_refuses_a_brick_in_the_air(compiled: Compiled):
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 1)
    lifted = samples.position_m.copy()
    lifted[0, samples.names.index("brick-5"), 2] += 0.01
    rows = list(Judge(prepare(compiled.plan)).violations(replace(samples, position_m=lifted)))
    assert "unsupported" in [row["kind"] for row in rows]


def test_a_stack_that_may_fall_is_refused(tmp_path: Path):
    report = compiled_from(tmp_path, PROGRAM.replace("0.008", "0.02")).report
    assert [d.code for d in report.diagnostics] == ["scene/stack-unsteady"]
    assert report.diagnostics[0].where.line == 7


def test_nothing_stands_on_a_ball(tmp_path: Path):
    text = PROGRAM.replace("    alone: {type: stack, members: [ball], surface: tabletop}\n", "")
    report = compiled_from(tmp_path, text.replace("[brick]", "[ball, brick]").replace("count: 5, ", "")).report
    assert [d.code for d in report.diagnostics] == ["scene/missing-anchor"]


@pytest.mark.parametrize(("turn", "code"), [("[10, -10]", "scene/range-reversed"), ("[0, 400]", "scene/invalid-value")])
def test_turns_are_checked(turn: str, code: str, tmp_path: Path):
    report = compiled_from(tmp_path, PROGRAM.replace("[-15, 15]", turn)).report
    assert [d.code for d in report.diagnostics] == [code]
