"""The smallest task file for every `task/` code that reading one can meet."""

from __future__ import annotations

from pathlib import Path

_UPRIGHT = "{_func: upright, object: cup}"


def task(success: str = _UPRIGHT, node: str = "", edges: str = "[]", score: str = "10") -> str:
    """A task of one node."""
    return (
        f"graph_task_generator:\n  nodes: [{{id: stand, score: {score}, success: {success}{node}}}]\n  edges: {edges}\n"
    )


SAMPLES: dict[str, str] = {
    "task/unknown-key": task(node=", timeout: 3"),
    "task/missing-key": task("{_func: inside, object: cup}"),
    "task/invalid-value": task(node=", timeout_s: -1"),
    "task/unknown-predicate": task("{_func: uprite, object: cup}"),
    "task/invalid-graph": task(edges="[{src: stand, dst: sit}]"),
    "task/degrees-suspected": task("{_func: upright, object: cup, tilt: 15}"),
    "task/points-normalised": task(score="4"),
}
NOT_FROM_A_TASK: dict[str, str] = {
    "task/points-not-ten": "tests/dsl/test_task_file.py",
    "task/unbound-role": "tests/cli/task/test_score.py",
    "task/ambiguous-role": "tests/cli/task/test_score.py",
    "task/state-missing": "tests/cli/task/test_score.py",
    "task/invalid-log": "tests/cli/task/test_score.py",
}


def write(text: str, folder: Path) -> Path:
    """The file of a sample."""
    path = folder / "task.yaml"
    path.write_text(text)
    return path
