"""A warm session gives the verdicts of a cold compile, and leaves things that an edit does not concern in place."""

from pathlib import Path

import numpy as np

from cli.scene.edit import saved
from scenec.check.judge_scene import violations
from scenec.compile import Compiled, compile_program
from scenec.emit.scene import compiled_scene
from scenec.ir.problem import Solved
from scenec.session import Session
from tests.support.bad_inputs.scene import BOUND
from tests.support.scene.library import open_bin

PROGRAM = """\
background: {{asset: {{type: box, size_m: [1.0, 0.6, 0.04]}}}}
anchors: {{top: {{object: background, surface: auto}}}}
objects:
  - {{id: book, asset: {{type: box, size_m: {book}}}}}
  - {{id: cup, asset: {{type: cylinder, radius_m: 0.04, height_m: 0.1}}}}
  - {{id: pen, asset: {{type: box, size_m: [0.14, 0.01, 0.01]}}}}
layout:
  nodes:
    book: {{object: book, placement: {{type: surface, surface: top}}}}
    cup: {{object: cup, placement: {{type: surface, surface: top}}}}
    pen: {{object: pen, placement: {{type: surface, surface: top}}}}
relations: [{{left_of: [book, cup], gap: {gap}}}]
"""


def at(compiled: Compiled) -> dict[str, tuple[float, float, float]]:
    return {item.id: item.position_m for item in compiled.scenes[0].objects}


def test_an_edit_moves_no_more_than_it_must_and_the_verdict_is_that_of_a_cold_compile(tmp_path: Path):
    file, session = tmp_path / "p.yaml", Session()
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=0.02))
    first = session.compile(file)
    assert first.scenes == compile_program(file).scenes
    for book, gap, verdict in (
        ("[0.2, 0.15, 0.04]", 0.02, "compiled"),
        ("[0.2, 0.15, 0.04]", 2.0, "infeasible"),
        ("[0.2, 0.15, 0.04", 0.02, "invalid_program"),
        ("[0.2, 0.15, 0.05]", 0.02, "compiled"),
    ):
        file.write_text(PROGRAM.format(book=book, gap=gap))
        cold, warm = compile_program(file), session.compile(file)
        assert warm.report.verdict == cold.report.verdict == verdict
        assert warm.report.diagnostics == cold.report.diagnostics
    last = session.last
    assert last is not None
    assert at(last) == at(first), "a higher book stands where the lower one stood"
    assert last.scenes[0].objects[0].prisms[0].high_m == 0.04 + 0.05


def test_a_saved_file_is_compiled_again(tmp_path: Path):
    file = tmp_path / "p.yaml"
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=0.02))
    edits = saved(Session(), file, tmp_path, wait_s=0.0)
    assert next(edits).report.verdict == "compiled"
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=3.25))
    assert next(edits).report.verdict == "infeasible"
    (tmp_path / "other.yaml").write_text("{}")
    assert next(edits).report.verdict == "infeasible"


def test_what_was_found_is_told_on_the_line_where_it_stands_now(tmp_path: Path):
    open_bin(tmp_path, "bowl", floor_m=0.02)
    file, session = tmp_path / "p.yaml", Session(tmp_path)
    for lines in (0, 3, 1):
        file.write_text("# a line\n" * lines + str(BOUND["scene/round-floor"]))
        warm, cold = session.compile(file), compile_program(file, tmp_path, explain=False)
        assert warm.report.diagnostics[0].code == "scene/round-floor"
        assert "`inside` in `a`" in warm.report.diagnostics[0].headline, "named as the program names it"
        assert warm.report.diagnostics[0] == cold.report.diagnostics[0]


STACKED = """\
background: {{asset: {{type: box, size_m: [1.2, 0.8, 0.04]}}}}
anchors:
  top: {{object: background, surface: auto}}
  on_tray: {{object: tray, surface: auto}}
  in_crate: {{object: tray, volume: {{outline: [[-0.14, -0.09], [0.14, -0.09], [0.14, 0.09], [-0.14, 0.09]], z: 0.02,
    height: 0.2}}}}
objects:
  - {{id: tray, asset: {{type: box, size_m: [{tray:.2f}, 0.20, 0.02]}}}}
  - {{id: cup, asset: {{type: cylinder, radius_m: {cup:.3f}, height_m: 0.1}}}}
  - {{id: pen, asset: {{type: box, size_m: [{pen:.2f}, 0.02, 0.02]}}}}
  - {{id: die, asset: {{type: box, size_m: [0.02, 0.02, 0.02]}}}}
layout:
  nodes:
    tray: {{object: tray, placement: {{type: surface, surface: top, ranges: {{yaw: [0.0, {yaw:.1f}]}}}}}}
    cup: {{object: cup, placement: {{type: surface, surface: {cup_on}}}}}
    pen: {{object: pen, placement: {{type: {pen_in}}}}}
    die: {{object: die, placement: {{type: surface, surface: top}}}}
relations:
  - {{left_of: [die, tray], gap: {gap:.2f}}}
clearance: {clearance:.3f}
"""


def test_every_scene_of_a_session_is_what_judge_and_emitter_make_of_it_from_nothing(tmp_path: Path):
    rng, file, session = np.random.default_rng(8), tmp_path / "p.yaml", Session()
    verdicts = set[str]()
    state = {"tray": 0.3, "cup": 0.03, "pen": 0.1, "yaw": 1.0, "gap": 0.02, "clearance": 0.01}
    state |= {"cup_on": "top", "pen_in": "surface, surface: top"}
    for _ in range(24):
        key = str(rng.choice(list(state)))
        state[key] = {
            "tray": rng.choice([0.30, 0.34, 0.40]),
            "cup": rng.choice([0.030, 0.040, 0.050]),
            "pen": rng.choice([0.10, 0.15, 0.25]),
            "yaw": rng.choice([0.0, 1.0, 3.0]),
            "gap": rng.choice([0.02, 0.30, 2.50]),
            "clearance": rng.choice([0.005, 0.010, 0.020]),
            "cup_on": rng.choice(["top", "on_tray"]),
            "pen_in": rng.choice(["surface, surface: top", "volume, volume: in_crate"]),
        }[key]
        file.write_text(STACKED.format(**state))
        warm = session.compile(file, explain=False)
        verdicts.add(warm.report.verdict)
        assert warm.report.verdict == compile_program(file, explain=False).report.verdict
        for problem, result, scene in zip(warm.problems, warm.results, warm.scenes, strict=False):
            assert isinstance(result, Solved)
            assert violations(problem, result.placements) == ()
            assert scene == compiled_scene(problem, result.placements, 0)
    assert verdicts == {"compiled", "infeasible"}


AROUND = """
background: {{asset: {{type: box, size_m: [1.2, 0.9, 0.04]}}}}
anchors: {{top: {{object: background, surface: auto}}}}
objects:
  - {{id: pot, asset: {{type: cylinder, radius_m: 0.05, height_m: 0.1}}}}
  - {{id: cube, asset: {{type: box, size_m: [0.05, 0.05, 0.05]}}}}
layout:
  nodes:
    pot: {{object: pot, placement: {{type: surface, surface: top}}}}
    a: {{object: cube}}
    b: {{object: cube}}
    c: {{object: cube}}
  groups: {{cubes: {{type: region, members: [a, b, c], surface: top}}}}
relations: [{{surrounding: [pot, a, b, c], least_angle_deg: {angle}}}]
"""


def test_a_changed_angle_is_no_edit_that_the_cache_overlooks(tmp_path: Path):
    file, session = tmp_path / "p.yaml", Session()
    for angle in (10, 100, 115):
        file.write_text(AROUND.format(angle=angle))
        compiled = session.compile(file)
        assert compiled.report.verdict == "compiled"
        (problem,), (result,) = compiled.problems, compiled.results
        assert isinstance(result, Solved)
        assert violations(problem, result.placements) == ()
