"""The smallest programs whose plans were wrong once: every compiled program gives a plan that draws valid scenes."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime_plan import prepare, sample
from runtime_plan.verify import Judge
from scenec.compile import compile_program

BOX = "{type: box, size_m: [0.1, 0.1, 0.05]}"
TABLE = "background: {asset: {type: box, size_m: [1.6, 1.6, 0.04]}}"
DISC = "background: {asset: {type: cylinder, radius_m: 0.4, height_m: 0.04}}"
TWO = """\
objects: [{id: a, asset: BOX}, {id: b, asset: BOX}]
layout:
  nodes:
    a: {object: a, placement: {type: surface, surface: top, ranges: {x: [0, 0], y: [0, 0], yaw: [0, 0]}}}
    b: {object: b, placement: {type: surface, surface: top, ranges: {x: [0.3, 0.3], y: [0, 0], yaw: [0, 0]}}}
"""
ONE = """\
objects: [{id: a, asset: BOX}]
layout:
  nodes:
    a: {object: a, placement: {type: surface, surface: top, ranges: RANGES}}
"""
REACHED = """\
objects:
  - {id: tray, asset: {type: box, size_m: [0.4, 0.3, 0.02]}}
  - {id: mug, asset: {type: cylinder, radius_m: 0.03, height_m: 0.08}}
layout:
  nodes:
    tray: {object: tray, placement: {type: surface, surface: top, ranges: {x: [0.3, 0.5], y: [-0.1, 0.1], yaw: [0, 0]}}}
    mug: {object: mug, placement: {type: surface, surface: onto}}
reach: {base: [-0.6, 0, 0], min_radius: 0.7, radius: 1.4}
"""
TIED = """\
objects:
  - {id: tray, asset: {type: box, size_m: [0.3, 0.2, 0.02]}}
  - {id: cup, asset: {type: box, size_m: [0.06, 0.05, 0.1]}}
  - {id: jar, asset: {type: box, size_m: [0.08, 0.07, 0.1]}}
layout:
  nodes:
    tray: {object: tray, placement: {type: surface, surface: top, ranges: {yaw_deg: [-90, 90]}}}
    cup: {object: cup, placement: {type: surface, surface: onto}}
    jar: {object: jar, placement: {type: surface, surface: top}}
"""
ACROSS = (
    "{left_of: [cup, jar], frame: tray}",
    "{left_of: [cup, jar], frame: world}",
    "{near: [cup, jar], distance: 0.1}",
    "{far_from: [cup, jar], distance: 0.3}",
    "{facing: [cup, jar]}",
    "{aligned: [cup, jar], axis: x, frame: world}",
    "{between: [cup, jar, tray], tolerance: 0.05}",
    "{surrounding: [jar, cup, tray], least_angle_deg: 10}",
    "{surrounding: [tray, cup, jar], evenly: true, tolerance_deg: 60, distance: 0.4}",
    "{in_line: [cup, jar], axis: x, tolerance: 0.05, frame: world}",
    "{in_line: [jar, cup], axis: y, spacing: 0.3, tolerance: 0.1, frame: tray}",
)
PROGRAMS = {
    "near, exactly met": TABLE + "\n" + TWO + "relations: [{near: [a, b], distance: 0.2}]\n",
    "facing without tolerance": TABLE + "\n" + TWO + "relations: [{facing: [a, b], tolerance: 0}]\n",
    "a range without width on a disc": DISC + "\n" + ONE.replace("RANGES", "{x: [0.1, 0.1], y: [-0.1, 0.1]}"),
    "a point on a disc": DISC + "\n" + ONE.replace("RANGES", "{x: [0.1, 0.1], y: [0.1, 0.1]}"),
    "reach of what a movable thing carries": TABLE + "\n" + REACHED,
}


@pytest.mark.parametrize("relation", ACROSS)
def test_a_relation_across_a_tray_holds_wherever_the_tray_is_drawn(relation: str, tmp_path: Path):
    file = tmp_path / "program.yaml"
    anchors = "anchors: {top: {object: background, surface: auto}, onto: {object: tray, surface: auto}}\n"
    file.write_text(f"{TABLE}\n{anchors}{TIED}relations: [{relation}]\nclearance: 0.01\n")
    compiled = compile_program(file, diversity=0.05)
    assert compiled.plan is not None, compiled.report.diagnostics
    plan = prepare(compiled.plan)
    drawn = sample(plan, 1000, 0)
    assert list(Judge(plan).violations(drawn)) == []
    tray = plan.tables.names.index("tray")
    assert (drawn.position_m[:, tray, :2].std(axis=0) > 0.05).all(), "the tray keeps its range"
    assert drawn.yaw_rad[:, tray].std() > 0.3


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_plan_draws_valid_scenes(name: str, tmp_path: Path):
    onto = ", onto: {object: tray, surface: auto}" if "tray" in PROGRAMS[name] else ""
    anchors = f"anchors: {{top: {{object: background, surface: auto}}{onto}}}\n"
    file = tmp_path / "program.yaml"
    file.write_text("scene: small\n" + anchors + PROGRAMS[name].replace("BOX", BOX))
    compiled = compile_program(file, diversity=0.1)
    assert compiled.report.verdict == "compiled", compiled.report.diagnostics
    assert compiled.plan is not None
    plan = prepare(compiled.plan)
    assert list(Judge(plan).violations(sample(plan, 500, 0))) == []
