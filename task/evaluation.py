"""Judges a whole state log: the history of the task graph, its score, labels, and what became of each node."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from schemas.arrays import BoolArray
from schemas.task.episode_result import EpisodeResult, Failure, NodeEvent, NodeResult, Stage
from schemas.task.scene_facts import SceneFacts
from schemas.task.state_log import StateLog
from task.frames import Frames
from task.graph import WHOLE, TaskGraph
from task.history import GraphHistory, active_at, graph_history
from task.labels import label_stretches
from task.motion_limits import first_teleport
from task.predicates.protocol import Predicate


def evaluate(graph: TaskGraph, log: StateLog, scene: SceneFacts) -> EpisodeResult:
    """The result of a log. Raises StateMissing where log or scene lack what a condition reads."""
    reached = graph_history(graph, log.t_s, LoggedConditions(graph, log, scene))
    return episode_result(graph, log.t_s.tolist(), reached)


@dataclass(frozen=True)
class LoggedConditions:
    """The conditions of a graph over a log. Implements `task.history.Conditions`."""

    graph: TaskGraph
    log: StateLog
    scene: SceneFacts

    def success(self, node: str, first: int) -> BoolArray:
        """See `task.history.Conditions`."""
        return self._values(self.graph.by_id[node].success, first)

    def failure(self, node: str, first: int) -> BoolArray | None:
        """See `task.history.Conditions`."""
        predicate = self.graph.by_id[node].failure
        return None if predicate is None else self._values(predicate, first)

    def task_failure(self) -> BoolArray | None:
        """See `task.history.Conditions`."""
        return None if self.graph.failure is None else self._values(self.graph.failure, 0)

    def jump(self) -> tuple[int, str] | None:
        """See `task.history.Conditions`."""
        teleport = first_teleport(self.log, bodies_of_task(self.graph, self.scene))
        return None if teleport is None else (teleport.frame, f"{teleport.body} jumped {teleport.distance_m:.3f} m")

    def _values(self, predicate: Predicate, first: int) -> BoolArray:
        return predicate.values(Frames(self.log, self.scene, first, len(self.log)), predicate.start())[0]


def predicates_of(graph: TaskGraph) -> tuple[Predicate, ...]:
    """All conditions of a task."""
    pairs = [(node.success, node.failure) for node in graph.nodes]
    return tuple(p for pair in (*pairs, (graph.failure,)) for p in pair if p is not None)


def bodies_of_task(graph: TaskGraph, scene: SceneFacts) -> tuple[str, ...]:
    """Bodies of the objects that the conditions of a task name, in order of their names."""
    names = {name for predicate in predicates_of(graph) for name in predicate.objects()}
    return tuple(sorted(scene.objects[name].body for name in names if name in scene.objects))


def episode_result(graph: TaskGraph, t_s: list[float], reached: GraphHistory) -> EpisodeResult:
    """The document of a history over frames with these stamps."""
    points = sum((graph.weights[v] for v in reached.completed), start=Fraction(0))
    failure = reached.failure
    return EpisodeResult(
        task=graph.name,
        frames=len(t_s),
        seconds=t_s[-1] - t_s[0],
        success=reached.success_frame is not None,
        success_frame=reached.success_frame,
        score=float(points),
        progress=float(points / WHOLE),
        events=tuple(NodeEvent(node=v, frame=frame, t_s=t_s[frame]) for frame, v in reached.events),
        failure=None
        if failure is None
        else Failure(
            reason=failure.reason,
            frame=failure.frame,
            t_s=t_s[failure.frame],
            nodes=failure.nodes,
            detail=failure.detail,
        ),
        nodes=tuple(_result(graph, v, t_s, reached) for v in graph.order),
        labels=label_stretches(reached.events),
        active_at_end=tuple(v for v in active_at(graph, reached, len(t_s) - 1) if v not in reached.completed),
    )


def scores(graph: TaskGraph, reached: GraphHistory, frames: int) -> list[float]:
    """Q[t]: points of ten by each frame; they never decrease."""
    gained = [Fraction(0)] * frames
    for frame, v in reached.events:
        gained[frame] += graph.weights[v]
    total, result = Fraction(0), list[float]()
    for points in gained:
        total += points
        result.append(float(total))
    return result


def _result(graph: TaskGraph, v: str, t_s: list[float], reached: GraphHistory) -> NodeResult:
    activated, completed = reached.activated.get(v), reached.completed.get(v)
    values = reached.values.get(v)
    undone: int | None = None
    if activated is not None and completed is not None and values is not None:
        lost = ~values[completed - activated :]
        undone = completed + int(np.argmax(lost)) if lost.any() else None
    stage: Stage = "never reached" if activated is None else "active"
    if completed is not None:
        stage = "completed" if undone is None else "completed, undone"
    return NodeResult(
        node=v,
        points=float(graph.weights[v]),
        stage=stage,
        activated=activated,
        completed=completed,
        seconds=None if completed is None or activated is None else t_s[completed] - t_s[activated],
        now=None if values is None else bool(values[-1]),
        undone=undone,
    )
