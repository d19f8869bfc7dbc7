"""Pictures of tasks: the graph, and the timeline of an episode."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from jobs.cache import write_atomically
from schemas.task.episode_result import EpisodeResult, NodeResult
from task.graph import TaskGraph

INK, PALE, PAPER = "#1c2028", "#8a919c", "#ffffff"
DONE, ACTIVE, WAITING, FAILED = "#2f7d4f", "#c98a1b", "#d5d8dd", "#b3372f"
_STEP, _BOX = (2.6, 1.05), (2.0, 0.7)
_DPI = 150


def draw_graph(graph: TaskGraph, path: Path, result: EpisodeResult | None = None) -> None:
    """Writes the graph from left to right as a PNG; of an episode with what became of each node."""
    depth = _depths(graph)
    columns = [[v for v in graph.order if depth[v] == k] for k in range(max(depth.values()) + 1)]
    tallest = max(len(column) for column in columns)
    at = {
        v: (k * _STEP[0], ((len(column) - 1) / 2.0 - row) * _STEP[1])
        for k, column in enumerate(columns)
        for row, v in enumerate(column)
    }
    nodes = {} if result is None else {node.node: node for node in result.nodes}
    width, height = len(columns) * _STEP[0], tallest * _STEP[1] + 0.8
    figure = Figure(figsize=(max(width, 4.0), max(height, 1.8)), dpi=_DPI, facecolor=PAPER)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(-_BOX[0] * 0.65, (len(columns) - 1) * _STEP[0] + _BOX[0] * 0.65)
    axes.set_ylim(-height / 2.0, height / 2.0 + 0.1)
    axes.axis("off")
    for a, b in graph.edges:
        start, end = (at[a][0] + _BOX[0] / 2.0, at[a][1]), (at[b][0] - _BOX[0] / 2.0, at[b][1])
        axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=12, color=PALE, linewidth=1.2))
    for v, (x, y) in at.items():
        face = _face(nodes.get(v), result)
        corner = (x - _BOX[0] / 2.0, y - _BOX[1] / 2.0)
        axes.add_patch(
            FancyBboxPatch(corner, *_BOX, boxstyle="round,pad=0,rounding_size=0.12", facecolor=face, edgecolor=INK)
        )
        ink = INK if face == WAITING else PAPER
        axes.text(x, y + 0.12, _short(v), ha="center", va="center", fontsize=10, color=ink, fontweight="bold")
        axes.text(x, y - 0.17, _second_line(graph, v, nodes.get(v)), ha="center", va="center", fontsize=7.5, color=ink)
    title = graph.name if result is None else f"{graph.name}: {verdict(result)}"
    axes.text(0.02, 0.98, title, transform=axes.transAxes, ha="left", va="top", fontsize=11, color=INK)
    _save(figure, path)


def draw_timeline(graph: TaskGraph, result: EpisodeResult, path: Path) -> None:
    """Writes when each node was active and done, the score, and the first failure, as a PNG."""
    rate = result.seconds / max(result.frames - 1, 1)
    rows = {v: row for row, v in enumerate(reversed(graph.order))}
    figure = Figure(figsize=(9.0, 1.9 + 0.34 * len(rows)), dpi=_DPI, facecolor=PAPER)
    axes, score = figure.subplots(2, 1, sharex=True, height_ratios=(max(len(rows), 2), 1.6))
    events = {event.node: event for event in result.events}
    for node in result.nodes:
        row = rows[node.node]
        if node.activated is None:
            continue
        begin = node.activated * rate
        end = result.seconds if node.completed is None else events[node.node].t_s
        axes.barh(row, max(end - begin, 0.0), left=begin, height=0.5, color=ACTIVE, alpha=0.55)
        if node.completed is not None:
            axes.barh(row, result.seconds - end, left=end, height=0.5, color=DONE, alpha=0.35)
            axes.plot([end], [row], marker="D", color=DONE, markersize=6)
        if node.undone is not None:
            axes.plot([node.undone * rate], [row], marker="x", color=FAILED, markersize=7)
    axes.set_yticks(list(rows.values()), [_short(v) for v in rows])
    axes.set_ylim(-0.6, len(rows) - 0.4)
    points, levels, stamps = 0.0, [0.0], [0.0]
    for event in result.events:
        stamps += [event.t_s, event.t_s]
        levels += [points, points + float(graph.weights[event.node])]
        points = levels[-1]
    score.plot([*stamps, result.seconds], [*levels, points], color=INK, linewidth=1.6)
    score.set_ylim(-0.5, 10.5)
    score.set_ylabel("score")
    score.set_xlabel("time (s)")
    if result.failure is not None:
        for each in (axes, score):
            each.axvline(result.failure.t_s, color=FAILED, linestyle="--", linewidth=1.2)
    for each in (axes, score):
        each.spines[["top", "right"]].set_visible(False)
        each.set_xlim(0.0, max(result.seconds, rate))
    axes.set_title(f"{graph.name}: {verdict(result)}", loc="left", fontsize=11)
    figure.text(
        0.99, 0.01, "active (amber), done (green), undone (x), failure (dashed)", ha="right", fontsize=7, color=PALE
    )
    figure.tight_layout()
    _save(figure, path)


def verdict(result: EpisodeResult) -> str:
    """A result in a few words."""
    if result.success:
        return f"success in frame {result.success_frame}, {result.score:g} of 10"
    failure = result.failure
    if failure is not None:
        nodes = f" of {', '.join(failure.nodes)}" if failure.nodes else ""
        return f"failed in frame {failure.frame}: {failure.reason}{nodes}, {result.score:g} of 10"
    return f"not finished: {', '.join(result.active_at_end)} still active, {result.score:g} of 10"


def _depths(graph: TaskGraph) -> dict[str, int]:
    depth: dict[str, int] = {}
    for v in graph.order:
        depth[v] = max((depth[u] + 1 for u in graph.predecessors[v]), default=0)
    return depth


def _face(node: NodeResult | None, result: EpisodeResult | None) -> str:
    if node is None or result is None:
        return WAITING
    failure = result.failure
    if failure is not None and node.node in failure.nodes:
        return FAILED
    return {"never reached": WAITING, "active": ACTIVE}.get(node.stage, DONE)


def _second_line(graph: TaskGraph, v: str, node: NodeResult | None) -> str:
    if node is not None and node.completed is not None:
        return f"frame {node.completed}{', later undone' if node.undone is not None else ''}"
    return f"{graph.by_id[v].success.func}, {float(graph.weights[v]):g} points"


def _short(name: str) -> str:
    return name if len(name) <= 24 else f"{name[:22]}..."


def _save(figure: Figure, path: Path) -> None:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    write_atomically(path, buffer.getvalue())
