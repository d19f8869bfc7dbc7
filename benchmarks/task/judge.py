"""Speed of judging: `python -m benchmarks.task.evaluation`.

Three figures, each the median of `RUNS`: processor time of one step of a graph of 20 nodes with given truth values; of
one online frame with 20 predicates evaluated, in the world of the tests' samples; of 280 s at 30 Hz judged offline by
the same graph. The graph is a ladder: two columns of ten nodes, each waiting for both nodes above it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from statistics import median

import numpy as np

from schemas.task.state_log import StateLog
from task.evaluation import evaluate
from task.graph import TaskGraph, TaskNode
from task.online import GraphState, OnlineJudge
from task.predicates.table import predicate_from
from tests.task.samples import SAMPLES
from tests.task.world import SCENE, logged

NODES, RUNS, FRAMES = 20, 9, 2000
LONG_FRAMES, RATE_HZ = 8400, 30.0
NEVER = {"_func": "joint_at", "joint": "nut/turn", "at_least": 99.0}


def main() -> None:
    """Prints the figures beside their bounds."""
    print(f"graph step, values given: {1e6 * median(steps() for _ in range(RUNS)):.1f} us a frame (bound 50)")
    print(f"all 20 nodes active: {1e6 * median(steps(idle=True) for _ in range(RUNS)):.1f} us a frame (bound 50)")
    print(f"20 predicates evaluated online: {1e3 * median(online() for _ in range(RUNS)):.2f} ms a frame (bound 2)")
    print(f"280 s at 30 Hz offline: {median(offline() for _ in range(RUNS)):.2f} s (bound 3)")


def ladder(active: bool) -> TaskGraph:
    """20 nodes with the conditions of different samples; with `active` all wait side by side, and none is ever done."""
    funcs = dict.fromkeys(sample.func for sample in SAMPLES)
    written = [next(s.written for s in SAMPLES if s.func == func) for func in funcs][:NODES]
    conditions = [predicate_from({"_func": "all_of", "of": [w, NEVER]} if active else w) for w in written]
    nodes = tuple(TaskNode(f"n{k:02d}", condition) for k, condition in enumerate(conditions))
    layers = [(f"n{2 * k:02d}", f"n{2 * k + 1:02d}") for k in range(NODES // 2)]
    edges = tuple((a, b) for above, below in pairwise(layers) for a in above for b in below)
    return TaskGraph("ladder", nodes, () if active else edges)


def steps(*, idle: bool = False) -> float:
    """Seconds of a step of the graph while one layer after the other is done, or while all nodes wait for something."""
    state = GraphState(ladder(active=idle))
    began = time.process_time()
    for frame in range(FRAMES):
        due = 0 if idle else frame * NODES // FRAMES
        state.advance(frame / RATE_HZ, lambda v, due=due: int(v[1:]) < due)
    return (time.process_time() - began) / FRAMES


def long_log(frames: int) -> StateLog:
    """The world at rest for so many frames, so that most conditions go on being evaluated."""
    return replace(logged(frames=frames), t_s=np.arange(frames) / RATE_HZ)


def online() -> float:
    """Seconds of a frame with all 20 conditions evaluated."""
    log, graph = long_log(60), ladder(active=True)
    rows = [log.rows(k, k + 1) for k in range(len(log))]
    online_judge = OnlineJudge(graph, SCENE)
    began = time.process_time()
    for frame in rows:
        online_judge.step(frame)
    return (time.process_time() - began) / len(rows)


def offline() -> float:
    """Seconds for the whole long log."""
    log, graph = long_log(LONG_FRAMES), ladder(active=True)
    return seconds(lambda: evaluate(graph, log, SCENE))


def seconds(action: Callable[[], object]) -> float:
    """Processor seconds of one call."""
    began = time.process_time()
    action()
    return time.process_time() - began


if __name__ == "__main__":
    main()
