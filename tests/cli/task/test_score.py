"""`mana task score` and `show` as a user runs them: state logs, recordings, and what cannot be judged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from cli.main import app
from schemas.files import array_files
from schemas.task.logged_scene import LOG_SUFFIX, LoggedScene
from schemas.task.state_log import StateLog
from tests.task.world import FRAMES, SCENE, logged

TASK = """\
instruction: Put the red block into the basket.
graph_task_generator:
  nodes:
    - {id: place, score: 6, success: {_func: inside, object: '@goods', container: basket}}
    - {id: rest, score: 4, success: {_func: dwell, for_s: 0.5, of: {_func: released, object: '@goods'}}}
  edges: [{src: place, dst: rest}]
roles: {goods: red}
"""


def carried() -> StateLog:
    """The red block goes into the basket in two seconds and stays there."""
    share = np.clip(np.arange(FRAMES) / 40.0, 0.0, 1.0)[:, None]
    way = np.array([[-0.3, 0.0, 0.02]]) * (1.0 - share) + np.array([[0.3, 0.0, 0.03]]) * share
    return logged(motion={"red": way})


def saved(log: StateLog, folder: Path, name: str = "episode") -> Path:
    """The file of a log in the small world."""
    path = folder / f"{name}{LOG_SUFFIX}"
    array_files.save(LoggedScene(name, log, SCENE), LoggedScene, path)
    return path


def run(*arguments: object, task: str = TASK, folder: Path) -> tuple[int, dict]:
    """Exit code and JSON of `mana task score`."""
    (folder / "task.yaml").write_text(task)
    command = ["task", "score", str(folder / "task.yaml"), *map(str, arguments), "--json"]
    result = CliRunner().invoke(app, command)
    return result.exit_code, json.loads(result.stdout)


def test_an_episode_is_judged_and_drawn(tmp_path: Path) -> None:
    code, document = run(saved(carried(), tmp_path), "--out", tmp_path / "out", folder=tmp_path)
    assert code == 0
    (episode,) = document["episodes"]
    assert episode["success"]
    assert episode["score"] == 10.0
    place, rest = episode["events"]
    assert (place["node"], rest["node"]) == ("place", "rest")
    assert rest["t_s"] - place["t_s"] == pytest.approx(0.5)
    assert episode["labels"] == [[1, place["frame"], "place"], [place["frame"] + 1, rest["frame"], "rest"]]
    assert json.loads((tmp_path / "out" / "episode.json").read_text())["task"] == "task"
    for kind in ("timeline", "graph"):
        picture = np.asarray(Image.open(tmp_path / "out" / f"episode.{kind}.png").convert("L"))
        assert (picture < 128).mean() > 0.001, "something is drawn"


def test_an_episode_that_fails_is_an_answer_and_an_error_only_where_success_is_required(tmp_path: Path) -> None:
    log = saved(logged(), tmp_path)
    code, document = run(log, folder=tmp_path)
    assert code == 0
    assert document["episodes"][0]["active_at_end"] == ["place"]
    assert run(log, "--require-success", folder=tmp_path)[0] == 1


def refusals(task: str, log: Path, folder: Path) -> list[str]:
    """Codes of the findings where nothing is judged."""
    code, document = run(log, task=task, folder=folder)
    assert code == 1
    assert document["episodes"] == []
    return [each["code"] for each in document["diagnostics"]]


def test_what_cannot_be_judged_is_said(tmp_path: Path) -> None:
    log = saved(carried(), tmp_path)
    assert refusals(TASK.replace("goods: red", "goods: rde"), log, tmp_path) == ["task/unbound-role"]
    assert refusals(TASK.replace("'@goods'", "'@block'"), log, tmp_path) == ["task/ambiguous-role"]
    no_inside = TASK.replace("container: basket", "container: box")
    assert refusals(no_inside, log, tmp_path) == ["task/state-missing"]
    torn = replace(carried(), position_m=carried().position_m[:-1])
    assert refusals(TASK, saved(torn, tmp_path, "torn"), tmp_path) == ["task/invalid-log"]
    cut = tmp_path / f"cut{LOG_SUFFIX}"
    cut.write_bytes(log.read_bytes()[:500])
    assert refusals(TASK, cut, tmp_path) == ["task/invalid-log"]


def test_one_bad_log_does_not_keep_the_others_from_being_judged(tmp_path: Path) -> None:
    good, bad = saved(carried(), tmp_path), tmp_path / f"bad{LOG_SUFFIX}"
    bad.write_bytes(b"no log")
    code, document = run(bad, good, folder=tmp_path)
    assert code == 1
    assert [each["episode"] for each in document["episodes"]] == ["episode"]
    assert [each["code"] for each in document["diagnostics"]] == ["task/invalid-log"]


def test_a_folder_of_logs_is_judged_and_namesakes_keep_their_files(tmp_path: Path) -> None:
    for folder, log in (("a", carried()), ("b", logged())):
        (tmp_path / "logs" / folder).mkdir(parents=True)
        saved(log, tmp_path / "logs" / folder)
    out = tmp_path / "out"
    code, document = run(tmp_path / "logs" / "a", tmp_path / "logs" / "b", "--out", out, folder=tmp_path)
    assert code == 0
    assert [(each["episode"], each["success"]) for each in document["episodes"]] == [
        ("a_episode", True),
        ("b_episode", False),
    ]
    assert {file.name for file in out.glob("*.json")} == {"a_episode.json", "b_episode.json"}


def test_show_prints_and_draws_the_graph(tmp_path: Path) -> None:
    (tmp_path / "task.yaml").write_text(TASK)
    command = ["task", "show", str(tmp_path / "task.yaml"), "--out", str(tmp_path / "graph.png"), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert [node["waits_for"] for node in document["nodes"]] == [[], ["place"]]
    assert document["nodes"][0]["success"] == {"_func": "inside", "object": "@goods", "container": "basket"}
    assert (tmp_path / "graph.png").stat().st_size > 1000
