"""Judges an episode frame by frame while it runs: events, failures and success are those of `task.evaluation`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from schemas.task.scene_facts import SceneFacts
from schemas.task.state_log import StateLog
from task.evaluation import bodies_of_task
from task.frames import Frames
from task.graph import TaskGraph
from task.history import FirstFailure
from task.motion_limits import first_teleport
from task.predicates.protocol import Predicate

Asked = Callable[[str], bool]


@dataclass
class GraphState:
    """The latches of a graph at a frame; `advance` takes it to the next one.

    `active` maps unfinished nodes with an open gate to the stamp of their activation (s), in the order of the graph.
    """

    graph: TaskGraph
    frame: int = -1
    began_s: float = 0.0
    completed: dict[str, int] = field(default_factory=dict[str, int])
    active: dict[str, float] = field(default_factory=dict[str, float])
    failure: FirstFailure | None = None
    end: int | None = None
    points: Fraction = Fraction(0)
    _waits: dict[str, int] = field(default_factory=dict[str, int])
    _after: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    _rank: dict[str, int] = field(default_factory=dict[str, int])
    _sinks_left: int = 0

    def __post_init__(self) -> None:
        self._rank = {v: k for k, v in enumerate(self.graph.order)}
        self._waits = {v: len(before) for v, before in self.graph.predecessors.items()}
        self._after = {v: [w for w in self.graph.order if v in self.graph.predecessors[w]] for v in self.graph.order}
        self._sinks_left = len(self.graph.sinks)

    @property
    def success(self) -> bool:
        """S: all sinks are done and nothing had failed by then."""
        return self.end is not None and self.failure is None

    @property
    def score(self) -> float:
        """Points of ten."""
        return float(self.points)

    def advance(
        self,
        t_s: float,
        holds: Asked,
        fails: Asked | None = None,
        *,
        task_fails: bool = False,
        jump: str | None = None,
    ) -> list[str]:
        """Nodes that this frame completes, in order. `holds` and `fails` are called for active nodes, `holds` also for
        completed ones that must last. `jump` names motion that cannot be.
        """
        self.frame += 1
        if self.frame == 0:
            self.began_s = t_s
            self.active = dict.fromkeys(self.graph.roots, t_s)
        failures: list[FirstFailure] = []
        lasting = [v for v in self.completed if self.graph.by_id[v].must_last]
        completions: list[str] = []
        open_now = list(self.active)
        for v in open_now:  # Grows: a completion opens gates of nodes that come later in the order.
            if not holds(v):
                continue
            self.completed[v] = self.frame
            completions.append(v)
            self.points += self.graph.weights[v]
            if not self._after[v]:
                self._sinks_left -= 1
            for w in self._after[v]:
                self._waits[w] -= 1
                if self._waits[w] == 0:
                    self.active[w] = t_s
                    open_now.append(w)
        active = tuple(sorted(self.active, key=self._rank.__getitem__))
        for v in sorted((*active, *lasting), key=self._rank.__getitem__) if lasting else active:
            if v in self.active:
                failures += self._node_failures(v, t_s, fails)
            elif not holds(v):
                failures.append(FirstFailure(self.frame, (v,), "undone", "its condition holds no more"))
        if task_fails:
            failures.append(FirstFailure(self.frame, active, "task-failure"))
        limit_s = self.graph.time_limit_s
        if limit_s is not None and t_s - self.began_s > limit_s:
            failures.append(FirstFailure(self.frame, active, "time-limit", f"more than {limit_s:g} s"))
        if jump is not None:
            failures.append(FirstFailure(self.frame, active, "teleport", jump))
        if self.failure is None and self.end is None and failures:
            self.failure = failures[0]
        for v in completions:
            del self.active[v]
        if self._sinks_left == 0 and self.end is None:
            self.end = self.frame
        return sorted(completions, key=self._rank.__getitem__)

    def _node_failures(self, v: str, t_s: float, fails: Asked | None) -> list[FirstFailure]:
        node, failures = self.graph.by_id[v], list[FirstFailure]()
        if self.completed.get(v) == 0 and not node.true_at_reset:
            failures.append(FirstFailure(0, (v,), "true-at-reset", "its condition holds in the first frame"))
        if fails is not None and node.failure is not None and fails(v):
            failures.append(FirstFailure(self.frame, (v,), "node-failure"))
        if node.timeout_s is not None and t_s - self.active[v] > node.timeout_s:
            failures.append(FirstFailure(self.frame, (v,), "timeout", f"more than {node.timeout_s:g} s"))
        return failures


class OnlineJudge:
    """Evaluates the conditions of a graph in each new frame. A frame is a state log of one row."""

    def __init__(self, graph: TaskGraph, scene: SceneFacts) -> None:
        self.state = GraphState(graph)
        self._graph, self._scene = graph, scene
        self._reset: StateLog | None = None
        self._before: StateLog | None = None
        self._carried: dict[tuple[str, str], Any] = {}
        self._bodies = bodies_of_task(graph, scene)

    def step(self, frame: StateLog) -> list[str]:
        """Nodes that this frame completes. Raises StateMissing."""
        self._reset = self._reset or frame
        rows = Frames(frame, self._scene, 0, 1, self._reset)
        answers: dict[str, bool] = {}

        def holds(v: str) -> bool:
            if v not in answers:
                answers[v] = self._value("success", v, self._graph.by_id[v].success, rows)
            return answers[v]

        def fails(v: str) -> bool:
            failure = self._graph.by_id[v].failure
            return failure is not None and self._value("failure", v, failure, rows)

        task_failure = self._graph.failure
        task_fails = task_failure is not None and self._value("failure", "", task_failure, rows)
        events = self.state.advance(float(frame.t_s[0]), holds, fails, task_fails=task_fails, jump=self._jump(frame))
        self._before = frame
        return events

    def _value(self, what: str, v: str, predicate: Predicate, rows: Frames) -> bool:
        key = (what, v)
        carry = self._carried[key] if key in self._carried else predicate.start()
        values, self._carried[key] = predicate.values(rows, carry)
        return bool(values[0])

    def _jump(self, frame: StateLog) -> str | None:
        if self._before is None:
            return None
        pair = joined(self._before, frame)
        teleport = first_teleport(pair, self._bodies)
        return None if teleport is None else f"{teleport.body} jumped {teleport.distance_m:.3f} m"


def joined(one: StateLog, other: StateLog) -> StateLog:
    """Rows of two logs of the same bodies, one after the other; poses only."""
    return StateLog(
        t_s=np.concatenate([one.t_s, other.t_s]),
        bodies=one.bodies,
        position_m=np.concatenate([one.position_m, other.position_m]),
        quat_wxyz=np.concatenate([one.quat_wxyz, other.quat_wxyz]),
    )
