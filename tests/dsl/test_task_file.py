"""Task files: what they mean, the paper's listing, and every error of a file in one run, each at its place."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from dsl.task_file import read_task
from tests.support.bad_inputs.task import task

PAPER = {
    "task/pick_place/vnext_dag.yaml": """\
graph_task_generator:
  nodes:
    - {id: place, include: task/pick_place/stages/place.yaml, score: 3}
    - {id: return, include: task/pick_place/stages/return.yaml, score: 1}
  edges:
    - {src: place, dst: return}
""",
    "task/pick_place/stages/place.yaml": """\
success:
  _func: object_near_destination
  object_cfg: '@pickable'
  destination_cfg: '@container'
""",
    "task/pick_place/stages/return.yaml": "success: {_func: home}\n",
}
FAULTY = """\
task: lift
graph_task_generator:
  nodes:
    - id: grasp
      success: {_func: held_by, object: '@pickable', off_suport: false}
      score: 3
    - id: lift
      success:
        _func: all_of
        of:
          - {_func: held_by, object: cube}
          - {_func: raisd, object: cube, over: table, height_m: 0.04}
          - {_func: upright, object: cube, tilt: 15}
      timeout_s: -3
      score: 1
    - {id: lift, success: {_func: upright, object: cube, tilt: -0.1}}
    - {id: end, success: {_func: inside, object: cube}, true_at_reset: 1}
  edges:
    - {src: grasp, dst: lft}
    - {src: grasp, dst: lift}
    - {src: lift, dst: grasp}
failur: 3
"""
EXPECTED = [
    ("task/unknown-key", 5, 54, "did you mean `off_support`?"),
    ("task/unknown-predicate", 12, 21, "did you mean `raised`?"),
    ("task/degrees-suspected", 13, 50, "did you mean `tilt_deg: 15`?"),
    ("task/invalid-value", 14, 18, "`timeout_s` of the node `lift` takes a number above 0"),
    ("task/invalid-graph", 16, 8, "the node `lift` stands here again; first at line 7"),
    ("task/invalid-value", 16, 64, "`tilt` of `upright` must be at least 0"),
    ("task/missing-key", 17, 26, "`inside` needs `container`"),
    ("task/invalid-value", 17, 72, "`true_at_reset` of the node `end` takes true or false"),
    ("task/invalid-graph", 19, 25, "`dst: lft` names no node; did you mean `lift`?"),
    ("task/invalid-graph", 21, 7, "nodes wait for each other: grasp -> lift -> grasp"),
    ("task/unknown-key", 22, 1, "did you mean `failure`?"),
]


def written(files: dict[str, str], folder: Path) -> None:
    """Files by their paths below a folder."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def test_the_listing_of_the_paper_compiles_verbatim(tmp_path: Path) -> None:
    written(PAPER, tmp_path)
    file, diagnostics = read_task(tmp_path / "task/pick_place/vnext_dag.yaml", tmp_path)
    assert file is not None
    assert file.graph.name == "vnext_dag"
    assert file.graph.order == ("place", "return")
    assert file.graph.predecessors["return"] == ("place",)
    assert dict(file.graph.weights) == {"place": Fraction(15, 2), "return": Fraction(5, 2)}
    assert list(file.graph.by_id["place"].success.objects()) == ["@pickable", "@container"]
    assert [d.code for d in diagnostics] == ["task/points-normalised"]


def test_points_of_a_benchmark_must_be_ten(tmp_path: Path) -> None:
    written(PAPER, tmp_path)
    file, diagnostics = read_task(tmp_path / "task/pick_place/vnext_dag.yaml", tmp_path, benchmark=True)
    assert file is None
    assert [(d.code, d.value, d.bound) for d in diagnostics] == [("task/points-not-ten", 4.0, 10.0)]


def test_points_are_exact(tmp_path: Path) -> None:
    thirds = "graph_task_generator:\n  nodes:\n" + "".join(
        f"    - {{id: n{k}, score: 0.1, success: {{_func: home}}}}\n" for k in range(3)
    )
    (tmp_path / "t.yaml").write_text(thirds)
    file, _ = read_task(tmp_path / "t.yaml")
    assert file is not None
    assert set(file.graph.weights.values()) == {Fraction(10, 3)}
    assert sum(file.graph.weights.values()) == 10


def test_all_errors_of_a_file_come_in_one_run_each_at_its_place(tmp_path: Path) -> None:
    (tmp_path / "t.yaml").write_text(FAULTY)
    file, diagnostics = read_task(tmp_path / "t.yaml")
    assert file is None
    assert len(diagnostics) == len(EXPECTED)
    for diagnostic, (code, line, column, words) in zip(diagnostics, EXPECTED, strict=True):
        assert (diagnostic.code, diagnostic.where.line, diagnostic.where.column) == (code, line, column)
        assert words in diagnostic.headline


def test_an_error_in_an_included_file_is_named_there(tmp_path: Path) -> None:
    written(PAPER | {"task/pick_place/stages/return.yaml": "success: {_func: hoome}\n"}, tmp_path)
    _, diagnostics = read_task(tmp_path / "task/pick_place/vnext_dag.yaml", tmp_path)
    wrong = next(d for d in diagnostics if d.code == "task/unknown-predicate")
    assert (wrong.where.file, wrong.where.line) == ("task/pick_place/stages/return.yaml", 1)


def test_an_overlay_changes_one_parameter(tmp_path: Path) -> None:
    over = "include: vnext_dag.yaml\ngraph_task_generator: {nodes: {place: {success: {distance_m: 0.03}}}}\n"
    written(PAPER | {"task/pick_place/near.yaml": over}, tmp_path)
    file, _ = read_task(tmp_path / "task/pick_place/near.yaml", tmp_path)
    assert file is not None
    assert file.graph.by_id["place"].success.written()["distance_m"] == 0.03


def test_degrees_are_turned_into_radians(tmp_path: Path) -> None:
    (tmp_path / "t.yaml").write_text(task("{_func: upright, object: cup, tilt_deg: 90}"))
    file, _ = read_task(tmp_path / "t.yaml")
    assert file is not None
    assert file.graph.by_id["stand"].success.written()["tilt"] == pytest.approx(1.5707963)


ODD = ["[]", "3", "graph_task_generator: []", "graph_task_generator: {nodes: 3}", "{}", "a: ["]


@pytest.mark.parametrize("text", ODD)
def test_odd_files_are_refused_with_a_place(text: str, tmp_path: Path) -> None:
    (tmp_path / "t.yaml").write_text(text)
    file, diagnostics = read_task(tmp_path / "t.yaml")
    assert file is None
    assert diagnostics
    assert all(d.where.file == "t.yaml" for d in diagnostics)


@pytest.mark.parametrize("success", ["3", "[]", "{object: cup}", "{_func: all_of, of: 3}", "{_func: all_of, of: [3]}"])
def test_odd_conditions_are_refused_without_a_word_of_python(success: str, tmp_path: Path) -> None:
    (tmp_path / "t.yaml").write_text(task(success))
    file, diagnostics = read_task(tmp_path / "t.yaml")
    assert file is None
    for each in diagnostics:
        assert not any(word in each.headline for word in ("tuple", "dict", "instance", "NoneType", "Input", "pydantic"))


def test_the_examples_are_read_without_a_finding() -> None:
    examples = sorted((Path(__file__).parents[2] / "examples" / "tasks").rglob("*.yaml"))
    assert len(examples) >= 15
    for example in examples:
        file, diagnostics = read_task(example, benchmark=True)
        assert file is not None
        assert not diagnostics
