"""The equations of the task graph over a whole episode: activation, completion, failure, success.

With d_v[t] for "v is done by frame t", g_v[t] for "all predecessors of v are done by t", c_v for its condition and F
for "something has failed by t":

    d_v[t] = d_v[t-1] or (g_v[t] and c_v[t])        S[t] = not F[t] and d_v[t] for all sinks v

The gate reads the same frame, so that a chain whose conditions hold is done in one frame. What the paper leaves open is
decided in docs/decisions/0013-task-graphs.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from schemas.task.episode_result import Reason
from task.graph import TaskGraph


class Conditions(Protocol):
    """Truth values of conditions over an episode of n frames, in the rows from `first` on."""

    def success(self, node: str, first: int) -> BoolArray:
        """Whether the condition of a node holds, for a node that is active from `first` on."""
        ...

    def failure(self, node: str, first: int) -> BoolArray | None:
        """Whether its failure condition holds; None where it has none."""
        ...

    def task_failure(self) -> BoolArray | None:
        """Whether the failure condition of the task holds, from frame 0 on; None where it has none."""
        ...

    def jump(self) -> tuple[int, str] | None:
        """The first frame with motion that cannot be, and what moved; None for a sound episode."""
        ...


class FirstFailure(NamedTuple):
    """The first failure: its frame, the node or the active nodes, why, and a word about it."""

    frame: int
    nodes: tuple[str, ...]
    reason: Reason
    detail: str = ""


@dataclass(frozen=True)
class GraphHistory:
    """What happened: first frames by node, completions (frame, node) in order, values of conditions from activation on.

    `end` is the frame in which all sinks were done, `success_frame` the same where nothing had failed by then.
    """

    activated: Mapping[str, int]
    completed: Mapping[str, int]
    events: tuple[tuple[int, str], ...]
    values: Mapping[str, BoolArray]
    failure: FirstFailure | None
    end: int | None

    @property
    def success_frame(self) -> int | None:
        """The first frame with S."""
        return self.end if self.failure is None else None


def graph_history(graph: TaskGraph, t_s: FloatArray, conditions: Conditions) -> GraphHistory:
    """The history of an episode with these stamps (n,)."""
    activated: dict[str, int] = {}
    completed: dict[str, int] = {}
    values: dict[str, BoolArray] = {}
    for v in graph.order:
        before = graph.predecessors[v]
        if any(u not in completed for u in before):
            continue
        activated[v] = max((completed[u] for u in before), default=0)
        values[v] = conditions.success(v, activated[v])
        if values[v].any():
            completed[v] = activated[v] + int(np.argmax(values[v]))
    rank = {v: k for k, v in enumerate(graph.order)}
    events = tuple(sorted(((frame, v) for v, frame in completed.items()), key=lambda e: (e[0], rank[e[1]])))
    end = max(completed[v] for v in graph.sinks) if all(v in completed for v in graph.sinks) else None
    reached = GraphHistory(activated, completed, events, values, None, end)
    last = len(t_s) - 1 if end is None else end
    failures = [f for f in _failures(graph, t_s, conditions, reached) if f.frame <= last]
    return GraphHistory(activated, completed, events, values, min(failures, key=lambda f: f.frame, default=None), end)


def active_at(graph: TaskGraph, reached: GraphHistory, frame: int) -> tuple[str, ...]:
    """Nodes whose gate is open in a frame and that were not done in the frame before."""
    return tuple(
        v
        for v in graph.order
        if reached.activated.get(v, frame + 1) <= frame and reached.completed.get(v, frame) >= frame
    )


def _failures(
    graph: TaskGraph, t_s: FloatArray, conditions: Conditions, reached: GraphHistory
) -> Iterator[FirstFailure]:
    """The first failure of each kind and node; of those in one frame the first one here is named."""
    n = len(t_s)
    for v in graph.order:
        node = graph.by_id[v]
        if v not in reached.activated:
            continue
        begin, done = reached.activated[v], reached.completed.get(v)
        stop = n if done is None else done + 1  # A node is active up to the frame of its completion.
        if done == 0 and not node.true_at_reset:
            yield FirstFailure(0, (v,), "true-at-reset", "its condition holds in the first frame")
        fails = conditions.failure(v, begin)
        if fails is not None and fails[: stop - begin].any():
            yield FirstFailure(begin + int(np.argmax(fails[: stop - begin])), (v,), "node-failure")
        if node.timeout_s is not None:
            late = t_s[begin:stop] - t_s[begin] > node.timeout_s
            if late.any():
                yield FirstFailure(begin + int(np.argmax(late)), (v,), "timeout", f"more than {node.timeout_s:g} s")
        if node.must_last and done is not None:
            lost = ~reached.values[v][done - begin :]
            if lost.any():
                yield FirstFailure(done + int(np.argmax(lost)), (v,), "undone", "its condition holds no more")
    fails = conditions.task_failure()
    if fails is not None and fails.any():
        frame = int(np.argmax(fails))
        yield FirstFailure(frame, active_at(graph, reached, frame), "task-failure")
    if graph.time_limit_s is not None:
        late = t_s - t_s[0] > graph.time_limit_s
        if late.any():
            frame = int(np.argmax(late))
            yield FirstFailure(
                frame, active_at(graph, reached, frame), "time-limit", f"more than {graph.time_limit_s:g} s"
            )
    jump = conditions.jump()
    if jump is not None:
        yield FirstFailure(jump[0], active_at(graph, reached, jump[0]), "teleport", jump[1])
