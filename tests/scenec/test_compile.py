"""Laws of the compiler: rigid motion of the background moves the scene, order does not matter, invalid scenes are
refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geom.pose import matrix_of, pose
from scenec.check import between_phases
from scenec.compile import compile_program
from tests.support.scene.problems import table_setting

OBJECTS = (
    "- {id: book, asset: {type: box, size_m: [0.21, 0.15, 0.03]}}",
    "- {id: cup, asset: {type: cylinder, radius_m: 0.04, height_m: 0.1}}",
    "- {id: bin, asset: {type: box, size_m: [0.3, 0.3, 0.1]}}",
)
PROGRAM = """\
background: {{asset: {{type: box, size_m: [1.0, 0.6, 0.04]}}{where}}}
anchors: {{top: {{object: background, surface: auto}}, lid: {{object: bin, surface: auto}}}}
objects:
{objects}
layout:
  nodes:
    book: {{object: book, placement: {{type: surface, surface: top}}}}
    bin: {{object: bin, placement: {{type: surface, surface: top, ranges: {{yaw_deg: [0, 30]}}}}}}
    cup: {{object: cup, placement: {{type: surface, surface: lid}}}}
relations: [{{left_of: [book, bin], gap: 0.02}}{more}]
"""


def program(folder: Path, name: str, where: str = "", more: str = "", order: tuple[int, ...] = (0, 1, 2)) -> Path:
    file = folder / f"{name}.yaml"
    file.write_text(PROGRAM.format(where=where, more=more, objects="\n".join(OBJECTS[i] for i in order)))
    return file


def test_a_moved_and_turned_background_takes_the_scene_along(tmp_path: Path):
    still = compile_program(program(tmp_path, "still")).scenes[0]
    turned = compile_program(program(tmp_path, "turned", ", position: [1.0, -2.0, 0.5], yaw_deg: 40")).scenes[0]
    cosine, sine = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    X = pose(np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]), (1.0, -2.0, 0.5))
    for before, after in zip(still.objects, turned.objects, strict=True):
        there = X @ pose(matrix_of(np.array(before.quat_wxyz)), before.position_m)
        np.testing.assert_allclose(there[:3, 3], after.position_m, atol=1e-8)
        np.testing.assert_allclose(there[:3, :3], matrix_of(np.array(after.quat_wxyz)), atol=1e-7)


@pytest.mark.parametrize("more", ["", ", {left_of: [bin, book]}"])
def test_the_order_of_objects_does_not_matter(more: str, tmp_path: Path):
    verdicts = {
        compile_program(program(tmp_path, "p", more=more, order=order), explain=False).report.verdict
        for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0))
    }
    assert len(verdicts) == 1


def test_a_scene_that_the_judge_refuses_does_not_leave_the_compiler():
    problem, placements = table_setting()
    between_phases.after_solving(problem, placements)
    onto_the_tray = {**placements, "book": replace(placements["tray"], yaw_rad=0.0)}
    with pytest.raises(RuntimeError, match="refuses"):
        between_phases.after_solving(problem, onto_the_tray)


def test_phases_are_counted_and_add_up(tmp_path: Path):
    report = compile_program(program(tmp_path, "p")).report
    assert list(report.phases) == ["read", "bind", "solve", "check", "emit"]
    assert sum(report.phases.values()) <= report.seconds
