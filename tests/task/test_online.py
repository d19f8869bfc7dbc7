"""An episode judged frame by frame gives the events, the failure and the success of the whole log."""

from __future__ import annotations

import numpy as np
import pytest

from schemas.task.state_log import StateLog
from task.evaluation import LoggedConditions, evaluate
from task.graph import TaskGraph, TaskNode
from task.history import graph_history
from task.online import OnlineJudge
from task.predicates.table import predicate_from
from tests.task.samples import SAMPLES
from tests.task.world import FRAMES, SCENE, logged

GRAPHS = 150


def shaken(seed: int) -> StateLog:
    """Bodies, joints and contacts that change every few frames to those of a random sample."""
    rng = np.random.default_rng(seed)
    logs = [SAMPLES[int(k)].log for k in rng.integers(0, len(SAMPLES), 12)]
    pick = np.repeat(np.arange(12), FRAMES // 12)
    base = logged()

    def mixed(name: str) -> np.ndarray:
        return np.stack([getattr(logs[p], name)[k] for k, p in enumerate(pick)])

    names = ("position_m", "quat_wxyz", "joint_position", "touching")
    arrays = {name: mixed(name) for name in names}
    return StateLog(
        bodies=base.bodies,
        joints=base.joints,
        contact_pairs=base.contact_pairs,
        grippers=base.grippers,
        t_s=base.t_s,
        **arrays,
    )


def random_graph(seed: int) -> TaskGraph:
    """Up to six nodes with conditions of the samples, failures, timeouts and nodes that must last."""
    rng = np.random.default_rng([seed, 1])
    count = int(rng.integers(1, 7))
    chosen = [predicate_from(SAMPLES[int(k)].written) for k in rng.integers(0, len(SAMPLES), 2 * count + 1)]
    nodes = tuple(
        TaskNode(
            f"n{k}",
            chosen[k],
            chosen[count + k] if rng.random() < 0.2 else None,
            float(rng.uniform(0.5, 3.0)) if rng.random() < 0.3 else None,
            true_at_reset=bool(rng.random() < 0.7),
            must_last=bool(rng.random() < 0.2),
        )
        for k in range(count)
    )
    edges = tuple((f"n{a}", f"n{b}") for a in range(count) for b in range(a + 1, count) if rng.random() < 0.4)
    limit_s = 2.0 if rng.random() < 0.2 else None
    return TaskGraph("random", nodes, edges, chosen[-1] if rng.random() < 0.1 else None, limit_s)


@pytest.mark.parametrize("first", range(0, GRAPHS, 50))
def test_online_and_offline_agree(first: int) -> None:
    successes = failures = 0
    for seed in range(first, first + 50):
        graph, log = random_graph(seed), shaken(seed)
        history = graph_history(graph, log.t_s, LoggedConditions(graph, log, SCENE))
        online = OnlineJudge(graph, SCENE)
        events = [(k, v) for k in range(len(log)) for v in online.step(log.rows(k, k + 1))]
        assert events == list(history.events), seed
        assert online.state.failure == history.failure, seed
        assert online.state.success == (history.success_frame is not None), seed
        assert online.state.score == evaluate(graph, log, SCENE).score, seed
        successes += online.state.success
        failures += online.state.failure is not None
    assert failures
    assert successes or first


def test_a_body_that_jumps_into_the_basket_is_no_success() -> None:
    inside = predicate_from({"_func": "inside", "object": "red", "container": "basket"})
    graph = TaskGraph("jump", (TaskNode("place", inside),))
    there = np.tile(np.array([-0.3, 0.0, 0.02]), (FRAMES, 1))
    there[30:] = (0.3, 0.0, 0.025)
    log = logged(motion={"red": there})
    result = evaluate(graph, log, SCENE)
    assert not result.success
    assert result.failure is not None
    assert (result.failure.reason, result.failure.frame) == ("teleport", 30)
    assert result.failure.detail == "red jumped 0.600 m"
    assert [event.node for event in result.events] == ["place"]
