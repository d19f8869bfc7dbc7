"""The equations of the task graph, written from the paper alone and frame by frame: no code of `task` is used.

g_v[t] = and over predecessors u of d_u[t]      d_v[t] = d_v[t-1] or (g_v[t] and c_v[t])
S[t] = not F[t] and all sinks d_v[t]            Q[t] = sum of w_v d_v[t]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction


@dataclass
class OracleNode:
    """Traces of one node: condition, failure condition; its timeout (s), weight and flags."""

    success: Sequence[bool]
    failure: Sequence[bool]
    timeout_s: float | None
    weight: Fraction
    true_at_reset: bool
    must_last: bool


@dataclass
class OracleAnswer:
    """d[v][t] by node, Q by frame, labels by frame, S by frame, and the first failure (frame, node, reason)."""

    done: dict[str, list[bool]]
    points: list[Fraction]
    labels: list[str | None]
    success: list[bool]
    failure: tuple[int, str, str] | None
    events: list[tuple[int, str]]


def answer(
    nodes: Mapping[str, OracleNode], edges: Sequence[tuple[str, str]], t_s: Sequence[float], limit_s: float | None
) -> OracleAnswer:
    """Everything, by the fixed point of the equations in each frame."""
    waits = {v: [a for a, b in edges if b == v] for v in nodes}
    sinks = [v for v in nodes if all(a != v for a, _ in edges)]
    order = ranked(nodes, waits)
    d = dict.fromkeys(nodes, False)
    activation: dict[str, int] = {}
    done: dict[str, list[bool]] = {v: [] for v in nodes}
    points: list[Fraction] = []
    success: list[bool] = []
    events: list[tuple[int, str]] = []
    failure: tuple[int, str, str] | None = None
    over = False
    for t, now in enumerate(t_s):
        before = dict(d)
        changed = True
        while changed:  # d_u[t] on the right side is that of the same frame: the least fixed point.
            changed = False
            for v in nodes:
                gate = all(d[u] for u in waits[v])
                if gate and v not in activation:
                    activation[v] = t
                if not d[v] and gate and nodes[v].success[t]:
                    d[v] = changed = True
        events += [(t, v) for v in order if d[v] and not before[v]]
        reasons: list[tuple[str, str]] = []
        for v in order:
            node = nodes[v]
            if v in activation and not before[v]:
                if t == 0 and d[v] and not node.true_at_reset:
                    reasons.append((v, "true-at-reset"))
                if node.failure[t]:
                    reasons.append((v, "node-failure"))
                if node.timeout_s is not None and now - t_s[activation[v]] > node.timeout_s:
                    reasons.append((v, "timeout"))
            if before[v] and node.must_last and not node.success[t]:
                reasons.append((v, "undone"))
        if limit_s is not None and now - t_s[0] > limit_s:
            reasons.append(("", "time-limit"))
        if reasons and failure is None and not over:
            failure = (t, *reasons[0])
        over = over or all(d[v] for v in sinks)
        for v in nodes:
            done[v].append(d[v])
        points.append(sum((nodes[v].weight for v in nodes if d[v]), start=Fraction(0)))
        success.append(over and failure is None)
    return OracleAnswer(done, points, labels_of(events, len(t_s)), success, failure, events)


def ranked(nodes: Mapping[str, OracleNode], waits: Mapping[str, Sequence[str]]) -> list[str]:
    """Nodes by the number of edges on the longest way to them, then by id."""

    def depth(v: str) -> int:
        return max((depth(u) + 1 for u in waits[v]), default=0)

    return sorted(nodes, key=lambda v: (depth(v), v))


def labels_of(events: Sequence[tuple[int, str]], frames: int) -> list[str | None]:
    """z_t = v_k for f_(k-1) < t <= f_k with f_0 = 0; none elsewhere."""
    labels: list[str | None] = [None] * frames
    bounds = [0, *(f for f, _ in events)]
    for k, (_, v) in enumerate(events):
        for t in range(frames):
            if bounds[k] < t <= bounds[k + 1]:
                labels[t] = v
    return labels
