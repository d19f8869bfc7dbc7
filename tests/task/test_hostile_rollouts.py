"""Episodes that try to pass for a success: twelve ways for each family of predicates; none does, each for its reason.

Rows of two samples, one that fulfils a condition and one that almost does, are mixed by a pattern over frames.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from schemas.arrays import BoolArray
from schemas.task.state_log import StateLog
from task.evaluation import evaluate
from task.graph import TaskGraph, TaskNode
from task.predicates.protocol import Predicate
from task.predicates.table import predicate_from
from tests.task.samples import SAMPLES, Sample
from tests.task.world import FRAMES, RATE_HZ, SCENE

FAMILIES = {"placement": "inside", "pose": "upright", "joints": "joint_at", "grip": "held_by", "combine": "all_of"}
NEVER = predicate_from({"_func": "joint_at", "joint": "nut/turn", "at_least": 99.0})


@dataclass(frozen=True)
class Pair:
    """The condition of a family, and the logs in which it holds and almost does."""

    written: dict[str, Any]
    fulfilled: StateLog
    almost: StateLog

    @property
    def condition(self) -> Predicate:
        """The predicate."""
        return predicate_from(self.written)

    def log(self, pattern: BoolArray) -> StateLog:
        """The log in which the condition holds in exactly these frames."""
        a, b = self.fulfilled, self.almost
        names = ("position_m", "quat_wxyz", "joint_position", "touching")
        mixed = {
            name: np.where(pattern.reshape(-1, *[1] * (getattr(a, name).ndim - 1)), getattr(a, name), getattr(b, name))
            for name in names
        }
        return replace(a, **mixed)


def pair(func: str) -> Pair:
    """The first samples of a predicate, true and almost."""

    def first(kind: str) -> Sample:
        return next(sample for sample in SAMPLES if (sample.func, sample.kind) == (func, kind))

    return Pair(dict(first("true").written), first("true").log, first("almost").log)


def frames(*spans: tuple[int, int]) -> BoolArray:
    """True in the frames of the spans, first and last included."""
    pattern = np.zeros(FRAMES, dtype=bool)
    for first, last in spans:
        pattern[first : last + 1] = True
    return pattern


Episode = tuple[TaskGraph, StateLog, str | None, tuple[str, ...]]
LAST = FRAMES - 1


def node(condition: Predicate, name: str = "goal", **more: Any) -> TaskNode:
    """A stage."""
    return TaskNode(name, condition, **more)


def dwelling(pair: Pair, for_s: float) -> Predicate:
    """The condition, for a time."""
    return predicate_from({"_func": "dwell", "of": pair.written, "for_s": for_s})


def _never(p: Pair) -> Episode:
    return TaskGraph("t", (node(p.condition),)), p.almost, None, ("goal",)


def _at_reset(p: Pair) -> Episode:
    return TaskGraph("t", (node(p.condition),)), p.log(frames((0, LAST))), "true-at-reset", ("goal",)


def _undone(p: Pair) -> Episode:
    graph = TaskGraph("t", (node(p.condition, must_last=True), node(NEVER, "end")), (("goal", "end"),))
    return graph, p.log(frames((10, 20))), "undone", ("goal",)


def _undone_in_the_last_frame(p: Pair) -> Episode:
    end = dwelling(p, 0.5)
    graph = TaskGraph(
        "t",
        (node(p.condition, must_last=True), node(end, "end", must_last=True), node(NEVER, "never")),
        (("goal", "end"), ("end", "never")),
    )
    return graph, p.log(frames((10, LAST - 1))), "undone", ("goal",)


def _late_by_a_frame(p: Pair) -> Episode:
    """Done in the frame in which the time is over."""
    return (
        TaskGraph("t", (node(p.condition, timeout_s=19.5 / RATE_HZ),)),
        p.log(frames((20, LAST))),
        "timeout",
        ("goal",),
    )


def _beyond_the_limit(p: Pair) -> Episode:
    graph = TaskGraph("t", (node(p.condition),), time_limit_s=29.5 / RATE_HZ)
    return graph, p.log(frames((30, LAST))), "time-limit", ("goal",)


def _fails_in_the_frame_of_success(p: Pair) -> Episode:
    return (
        TaskGraph("t", (node(p.condition, failure=p.condition),)),
        p.log(frames((20, LAST))),
        "node-failure",
        ("goal",),
    )


def _task_fails_before(p: Pair) -> Episode:
    graph = TaskGraph("t", (node(dwelling(p, 0.5)),), failure=p.condition)
    return graph, p.log(frames((20, LAST))), "task-failure", ("goal",)


def _out_of_turn(p: Pair) -> Episode:
    """The second condition holds before the first stage is done, and no more afterwards."""
    turned = predicate_from({"_func": "negation", "of": p.written})
    graph = TaskGraph("t", (node(p.condition, "first"), node(turned, "second")), (("first", "second"),))
    return graph, p.log(frames((30, LAST))), None, ("second",)


def _flickers(p: Pair) -> Episode:
    pattern = frames(*((k, k + 3) for k in range(2, FRAMES - 4, 6)))
    return TaskGraph("t", (node(dwelling(p, 0.5)),)), p.log(pattern), None, ("goal",)


def _breaks_off_just_before(p: Pair) -> Episode:
    return TaskGraph("t", (node(dwelling(p, 10.0 / RATE_HZ)),)), p.log(frames((5, 14), (20, 29))), None, ("goal",)


def _jumps(p: Pair) -> Episode:
    """What the task names is far away, and the next moment where it should be."""
    log = p.log(frames((20, LAST)))
    names = list(p.condition.objects())
    nodes = [node(p.condition)]
    if not names:  # A condition on joints names no object; another stage does.
        names = ["red"]
        nodes.append(node(predicate_from({"_func": "released", "object": "red"}), "watch", true_at_reset=True))
    position = log.position_m.copy()
    for name in names:
        position[:20, log.body_index[SCENE.objects[name].body]] += np.array([0.0, 5.0, 0.0])
    return TaskGraph("t", tuple(nodes)), replace(log, position_m=position), "teleport", ("goal",)


WAYS: dict[str, Callable[[Pair], Episode]] = {
    "almost, all the time": _never,
    "true at reset": _at_reset,
    "done and undone": _undone,
    "undone in the last frame": _undone_in_the_last_frame,
    "timeout in the same frame": _late_by_a_frame,
    "after the time limit": _beyond_the_limit,
    "failure in the same frame": _fails_in_the_frame_of_success,
    "the task failed before": _task_fails_before,
    "the stages out of turn": _out_of_turn,
    "flickers": _flickers,
    "breaks off a frame too early": _breaks_off_just_before,
    "teleport": _jumps,
}


@pytest.mark.parametrize("family", FAMILIES)
def test_the_samples_are_what_the_patterns_need(family: str) -> None:
    p = pair(FAMILIES[family])
    pattern = frames((10, 20), (30, LAST))
    graph = TaskGraph("t", (node(p.condition, true_at_reset=True),))
    result = evaluate(graph, p.log(pattern), SCENE)
    assert result.success
    assert result.success_frame == 10
    (stage,) = result.nodes
    assert stage.undone == 21


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("family", FAMILIES)
def test_no_way_passes_for_a_success_and_each_fails_for_its_reason(family: str, way: str) -> None:
    graph, log, reason, nodes = WAYS[way](pair(FAMILIES[family]))
    result = evaluate(graph, log, SCENE)
    assert not result.success
    if reason is None:
        assert result.failure is None
        assert result.active_at_end == nodes
    else:
        assert result.failure is not None
        assert (result.failure.reason, result.failure.nodes) == (reason, nodes)
