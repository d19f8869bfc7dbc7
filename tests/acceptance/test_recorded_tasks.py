"""Demonstration demonstrations of robosuite, judged by Mana's tasks and by the rules of robosuite 1.0.

The rules are written here from the environments' documentation and read the recorded numbers alone: no code of Mana.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from cli.main import app
from tests.conftest import SHARED

EXAMPLES = Path(__file__).parents[2] / "examples" / "tasks"
EPISODES = SHARED / "episodes"
TABLE_TOP_M, LIFTED_M = 0.8, 0.04
MOST_FRAMES_APART = 2
# Bins of PickPlace: where the second one stands, its edges, and the quarter of each thing.
BIN_CORNER_M, BIN_EDGES_M = (0.1, 0.28, 0.8), (0.39, 0.49)
QUARTERS = {"Milk0": 0, "Bread0": 1, "Cereal0": 2, "Can0": 3}

pytestmark = pytest.mark.shared


class Demonstration:
    """Columns of one recording."""

    def __init__(self, name: str) -> None:
        self.columns = pq.read_table(EPISODES / name / "episode.parquet").to_pydict()
        self.links = pq.read_table(EPISODES / name / "links_fk.parquet").to_pydict()

    def position(self, body: str) -> np.ndarray:
        """(n, 3) of an object."""
        return np.stack([np.array(self.columns[f"obj.{body}.p{axis}"]) for axis in "xyz"], axis=1)

    def grip_site(self) -> np.ndarray:
        """(n, 3) between the tips of the fingers, where robosuite has its grip site."""
        tips = [
            np.stack([np.array(self.links[f"gripper0_finger_joint{k}_tip.p{axis}"]) for axis in "xyz"], axis=1)
            for k in (1, 2)
        ]
        return (tips[0] + tips[1]) / 2.0

    def opening(self) -> np.ndarray:
        """(n,) distance of the fingers (m)."""
        return np.array(self.columns["q.gripper0_finger_joint1"]) - np.array(self.columns["q.gripper0_finger_joint2"])


def lift_rule(episode: Demonstration) -> np.ndarray:
    """The cube's centre is more than 4 cm over the table."""
    return episode.position("cube")[:, 2] > TABLE_TOP_M + LIFTED_M


def stack_rule(episode: Demonstration) -> np.ndarray:
    """Cube A is lifted, touches cube B, and no finger touches it: for cubes of 4 and 5 cm and open fingers."""
    a, b = episode.position("cubeA"), episode.position("cubeB")
    touching = (np.abs(a[:, 2] - b[:, 2] - 0.045) < 0.002) & (np.abs((a - b)[:, :2]) < 0.045).all(axis=1)
    return (a[:, 2] > TABLE_TOP_M + LIFTED_M) & touching & (episode.opening() > 0.042)


def bin_rule(episode: Demonstration) -> np.ndarray:
    """Each thing is in its quarter of the second bin, and the grip site is away from it."""
    result = np.ones(len(episode.opening()), dtype=bool)
    for name, number in QUARTERS.items():
        x, y, z = episode.position(name).T
        low_x = BIN_CORNER_M[0] - (BIN_EDGES_M[0] / 2.0 if number in (0, 2) else 0.0)
        low_y = BIN_CORNER_M[1] - (BIN_EDGES_M[1] / 2.0 if number < 2 else 0.0)
        placed = (low_x < x) & (x < low_x + BIN_EDGES_M[0] / 2.0) & (low_y < y) & (y < low_y + BIN_EDGES_M[1] / 2.0)
        placed &= (BIN_CORNER_M[2] < z) & (z < BIN_CORNER_M[2] + 0.1)
        away = np.linalg.norm(episode.grip_site() - episode.position(name), axis=1)
        result &= placed & (1.0 - np.tanh(10.0 * away) < 0.6)
    return result


def test_a_folder_of_recordings_is_judged_and_others_are_named() -> None:
    command = ["task", "score", str(EXAMPLES / "stack_two_cubes.yaml"), str(EPISODES), "--json"]
    result = CliRunner().invoke(app, command)
    document = json.loads(result.stdout)
    assert result.exit_code == 1
    assert [(each["episode"], each["success"]) for each in document["episodes"]] == [("panda_stack", True)]
    assert {each["code"] for each in document["diagnostics"]} == {"task/unbound-role"}


@pytest.mark.parametrize(
    ("recording", "task", "rule"),
    [
        ("panda_lift", "lift_cube", lift_rule),
        ("panda_stack", "stack_two_cubes", stack_rule),
        ("panda_pick_place", "sort_groceries", bin_rule),
    ],
)
def test_success_comes_in_the_frame_of_robosuite(
    recording: str, task: str, rule: Callable[[Demonstration], np.ndarray]
) -> None:
    command = ["task", "score", str(EXAMPLES / f"{task}.yaml"), str(EPISODES / recording), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0
    (episode,) = json.loads(result.stdout)["episodes"]
    assert episode["success"]
    theirs = rule(Demonstration(recording))
    assert theirs.any()
    assert abs(episode["success_frame"] - int(np.argmax(theirs))) <= MOST_FRAMES_APART
