"""Random graphs and traces: whole and online judgement give bit for bit what an oracle of the equations gives.

A slice runs here; `python -m tests.task.test_graphs_against_oracle 100000` runs as many as wanted.
"""

from __future__ import annotations

import sys
from fractions import Fraction
from typing import ClassVar

import numpy as np
import pytest
from typing_extensions import override

from schemas.arrays import BoolArray, FloatArray
from task.evaluation import scores
from task.frames import Frames
from task.graph import TaskGraph, TaskNode
from task.history import graph_history
from task.labels import frame_labels, label_stretches
from task.online import GraphState
from task.predicates.protocol import Instant
from tests.task.oracle import OracleNode, answer

CASES, BLOCK = 3_000, 500


class NeverAsked(Instant):
    """Stands in a graph whose traces are given."""

    func: ClassVar[str] = "never_asked"

    @override
    def holds(self, frames: Frames) -> BoolArray:
        raise AssertionError


class Traces:
    """Random truth values of a random graph: up to 9 nodes, 40 frames, stamps at uneven steps."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        count, frames = int(rng.integers(1, 10)), int(rng.integers(1, 41))
        names = [f"n{k}" for k in rng.permutation(count)]
        chance = rng.uniform(0.0, 0.9)
        self.edges = tuple(
            (names[a], names[b]) for a in range(count) for b in range(a + 1, count) if rng.random() < chance
        )
        self.t_s: FloatArray = np.cumsum(rng.choice([0.02, 0.05, 0.1], frames))
        rate = rng.choice([0.02, 0.1, 0.5, 0.9])
        self.nodes = {
            v: OracleNode(
                success=self._trace(rng, frames, rate),
                failure=self._trace(rng, frames, 0.02) if rng.random() < 0.3 else [False] * frames,
                timeout_s=float(rng.uniform(0.0, 2.0)) if rng.random() < 0.3 else None,
                weight=Fraction(int(rng.integers(1, 7))),
                true_at_reset=bool(rng.random() < 0.8),
                must_last=bool(rng.random() < 0.2),
            )
            for v in sorted(names)
        }
        total = sum(node.weight for node in self.nodes.values())
        for node in self.nodes.values():
            node.weight = node.weight * 10 / total
        self.limit_s = float(rng.uniform(0.5, 3.0)) if rng.random() < 0.3 else None

    def _trace(self, rng: np.random.Generator, frames: int, rate: float) -> list[bool]:
        """Runs of equal values more often than single ones."""
        runs = np.repeat(rng.random(frames) < rate, rng.integers(1, 4, frames))[:frames]
        return [bool(value) for value in runs]

    def graph(self) -> TaskGraph:
        """The same as a task."""
        return TaskGraph(
            "random",
            tuple(
                TaskNode(v, NeverAsked(), NeverAsked(), o.timeout_s, o.weight, o.true_at_reset, o.must_last)
                for v, o in self.nodes.items()
            ),
            self.edges,
            time_limit_s=self.limit_s,
        )

    def success(self, node: str, first: int) -> BoolArray:
        """See `Conditions`."""
        return np.array(self.nodes[node].success[first:])

    def failure(self, node: str, first: int) -> BoolArray | None:
        """See `Conditions`."""
        return np.array(self.nodes[node].failure[first:])

    def task_failure(self) -> BoolArray | None:
        """See `Conditions`."""
        return None

    def jump(self) -> tuple[int, str] | None:
        """See `Conditions`."""
        return None


def check(seed: int) -> None:
    """One random case."""
    traces = Traces(seed)
    graph, frames = traces.graph(), len(traces.t_s)
    expected = answer(traces.nodes, traces.edges, traces.t_s.tolist(), traces.limit_s)
    reached = graph_history(graph, traces.t_s, traces)
    assert list(reached.events) == expected.events
    assert {v: frame for frame, v in reached.events} == {
        v: done.index(True) for v, done in expected.done.items() if any(done)
    }
    assert scores(graph, reached, frames) == [float(points) for points in expected.points]
    assert list(frame_labels(label_stretches(reached.events), frames)) == expected.labels
    assert (reached.success_frame is not None) == any(expected.success)
    if reached.success_frame is not None:
        assert reached.success_frame == expected.success.index(True)
    failure = reached.failure
    named = None if failure is None else (failure.frame, failure.nodes[0] if failure.reason != "time-limit" else "")
    assert named == (None if expected.failure is None else expected.failure[:2])
    assert (failure.reason if failure else None) == (expected.failure[2] if expected.failure else None)

    state, events = GraphState(graph), list[tuple[int, str]]()
    for t, now in enumerate(traces.t_s.tolist()):
        completed = state.advance(
            now, lambda v, t=t: traces.nodes[v].success[t], lambda v, t=t: traces.nodes[v].failure[t]
        )
        events += [(t, v) for v in completed]
        assert state.success == expected.success[t]
        assert state.score == float(expected.points[t])
    assert events == expected.events
    assert state.failure == reached.failure


@pytest.mark.parametrize("first", range(0, CASES, BLOCK))
def test_random_graphs_are_judged_as_the_equations_say(first: int) -> None:
    for seed in range(first, first + BLOCK):
        check(seed)


if __name__ == "__main__":
    for case in range(int(sys.argv[1])):
        check(case)
    print(f"{sys.argv[1]} cases agree")
