"""Grids: draws keep the pitch while the whole moves and turns, names of rows count, the judge sees a shifted member."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime_plan.plan import prepare
from runtime_plan.samples_file import as_document
from runtime_plan.verify import Judge
from scenec.compile import Compiled, compile_program
from tests.support.scene.drawn import drawn

PROGRAM = """\
background: {asset: {type: box, size_m: [0.8, 0.6, 0.05]}, yaw_deg: 30}
anchors: {tabletop: {object: background}}
objects: [{id: can, asset: {type: cylinder, radius_m: 0.03, height_m: 0.1}}]
layout:
  nodes: {can: {object: can}, lone: {object: can, placement: {type: surface, surface: tabletop}}}
  groups:
    rack:
      {type: grid, members: [can], surface: tabletop, rows: [near, far], columns: 2, pitch: [0.1, 0.15],
       ranges: {x: [-0.1, 0.2], yaw_deg: [-40, 40]}}
"""
CANS = ["can-near-1", "can-near-2", "can-far-1", "can-far-2"]


def compiled_from(folder: Path, text: str) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", diversity=0.1)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return compiled_from(tmp_path_factory.mktemp("grid"), PROGRAM)


def test_the_grid_is_no_object_of_the_scene_and_its_members_stand_on_the_table(compiled: Compiled):
    (scene,) = compiled.scenes
    assert {placed.id: placed.parent for placed in scene.objects} == dict.fromkeys([*CANS, "lone"], "background")


def test_draws_keep_the_pitch_and_move_the_whole(compiled: Compiled):
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 500)
    assert sorted(samples.names) == sorted([*CANS, "lone"])
    near_1, near_2, far_1, far_2 = (samples.position_m[:, samples.names.index(name), :2] for name in CANS)
    np.testing.assert_allclose(np.hypot(*(near_2 - near_1).T), 0.1, atol=1e-9)
    np.testing.assert_allclose(np.hypot(*(far_1 - near_1).T), 0.15, atol=1e-9)
    np.testing.assert_allclose(far_2 - far_1, near_2 - near_1, atol=1e-9)
    headings = np.degrees(np.arctan2(*(near_2 - near_1).T[::-1])) - 30.0
    assert -40.0 - 1e-6 <= headings.min() < -30.0
    assert 30.0 < headings.max() <= 40.0 + 1e-6
    assert np.ptp(near_1, axis=0).min() > 0.1
    assert list(Judge(prepare(compiled.plan)).violations(samples)) == []
    assert set(as_document(prepare(compiled.plan), samples).samples[0].objects) == {*CANS, "lone"}


def test_the_judge_sees_a_member_beside_its_cell_a_turned_one_and_a_grid_out_of_its_ranges(compiled: Compiled):
    assert compiled.plan is not None
    samples, judge = drawn(compiled.plan, 1), Judge(prepare(compiled.plan))
    columns = [samples.names.index(name) for name in CANS]
    shifted, moved = samples.position_m.copy(), samples.position_m.copy()
    shifted[0, columns[3], 0] += 0.005
    moved[0, columns, :2] += 0.4 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    kinds = [(row["kind"], row["things"][0]) for row in judge.violations(replace(samples, position_m=shifted))]
    assert ("grid", "can-far-2") in kinds
    kinds = [(row["kind"], row["things"][0]) for row in judge.violations(replace(samples, position_m=moved))]
    assert ("range", "rack") in kinds
    turned = samples.quat_wxyz.copy()
    turned[0, columns[1]] = [0.0, 0.0, 0.0, 1.0] if abs(turned[0, columns[1], 0]) > 0.7 else [1.0, 0.0, 0.0, 0.0]
    kinds = [(row["kind"], row["things"][0]) for row in judge.violations(replace(samples, quat_wxyz=turned))]
    assert ("grid", "can-near-2") in kinds


def test_rows_columns_and_cells_are_named_in_relations(tmp_path: Path):
    relations = "relations: [{left_of: [lone, rack.column_1], frame: rack.column_1}]\n"
    report = compiled_from(tmp_path, PROGRAM + relations).report
    assert [d.code for d in report.diagnostics] == ["scene/unknown-name"]  # a line of a grid has no frame
    relations = "relations: [{near: [lone, rack.far], distance: 0.4}, {far_from: [lone, can-near-1], distance: 0.1}]\n"
    compiled = compiled_from(tmp_path, PROGRAM + relations)
    assert compiled.report.verdict == "compiled"
    assert [r.things for r in compiled.problems[0].relations] == [
        ("lone", "can-far-1"), ("lone", "can-far-2"), ("lone", "can-near-1"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("columns: 2", "columns: [near, b]", "scene/duplicate-id"),
        ("members: [can]", "members: [can, lone]", "scene/grid-size"),
        ("pitch: [0.1, 0.15]", "pitch: [0.1]", "scene/invalid-value"),
    ],
)
def test_grids_are_checked(old: str, new: str, code: str, tmp_path: Path):
    report = compiled_from(tmp_path, PROGRAM.replace(old, new)).report
    assert code in [d.code for d in report.diagnostics]


def test_a_pitch_that_is_too_small_has_no_scene(tmp_path: Path):
    assert compiled_from(tmp_path, PROGRAM.replace("0.15]", "0.05]")).report.verdict == "infeasible"
