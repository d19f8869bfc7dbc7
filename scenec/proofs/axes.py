"""Difference constraints along one axis: cycles of relations, and chains too long for their place.

Along a unit direction d of a frame, the begin b, origin o and end f of each footprint are numbers, and support, ranges,
`before`, `near`, `aligned` and reach bound differences of two of them from below: v - u >= w. Theorem (Bellman 1958):
such a system has a solution iff no cycle has a positive sum of w. Widths and supports are the least over all allowed
yaws and orientations, so a positive cycle excludes every scene.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geom.planar import turned
from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.constraints import BEGIN, END, ORIGIN
from scenec.proofs.outlines import OUTLINE_SLACK_M, YawCell, hull, least_width, resting_orientations, support_bounds
from scenec.proofs.places import area_hull, background_yaw
from scenec.relations.table import RELATIONS
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, SceneRelation
from source.tree import Path


@dataclass(frozen=True)
class DifferenceReason:
    """Origin of one difference constraint, for the text of the proof."""

    kind: str
    text: str
    path: Path


@dataclass
class DifferenceConstraints:
    """System of difference constraints: edges u -> v with v - u >= w, and the reason of each."""

    u: list[int] = field(default_factory=list)
    v: list[int] = field(default_factory=list)
    w: list[float] = field(default_factory=list)
    reasons: list[DifferenceReason] = field(default_factory=list)

    def add_lower_bound(self, u: int, v: int, w: float, reason: DifferenceReason) -> None:
        """Adds v - u >= w if w is finite."""
        if np.isfinite(w):
            self.u.append(u)
            self.v.append(v)
            self.w.append(w - OUTLINE_SLACK_M)
            self.reasons.append(reason)


def too_long_along_an_axis(problem: Problem) -> Proof | None:
    """A proof when the constraints along some direction of some frame contradict each other."""
    yaws = {
        root: yaw_ranges(problem, root) for root in dict.fromkeys([BACKGROUND, *(t.parent for t in problem.things)])
    }
    for root, yaw_range_of in yaws.items():
        for direction in _directions(problem, yaw_range_of):
            system = _system(problem, root, yaw_range_of, direction)
            cycle = positive_cycle(system) if system.u else None
            if cycle is not None:
                return _proof(system, cycle, direction)
    return None


def yaw_ranges(problem: Problem, root: str) -> dict[str, YawCell]:
    """Yaw interval, in the frame of `root`, of all things on it, through any number of owners."""
    yaw_range_of: dict[str, YawCell] = {root: (0.0, 0.0)}
    waiting = list(problem.things)
    while ready := [thing for thing in waiting if thing.parent in yaw_range_of and thing.name != root]:
        for thing in ready:
            low, high = _yaw_range(thing)
            yaw_range_of[thing.name] = (yaw_range_of[thing.parent][0] + low, yaw_range_of[thing.parent][1] + high)
        waiting = [thing for thing in waiting if thing.name not in yaw_range_of]
    return yaw_range_of


def _yaw_range(thing: Thing) -> YawCell:
    if not thing.domain.fixed_poses:
        return thing.domain.yaw_rad
    yaws = [fixed_pose.yaw_rad for fixed_pose in thing.domain.fixed_poses]
    return min(yaws), max(yaws)


def _directions(problem: Problem, yaw_range_of: dict[str, YawCell]) -> list[FloatArray]:
    """The axes of the frame and the directions of relations in it, each once regardless of sign."""
    candidates = [np.array([1.0, 0.0]), np.array([0.0, 1.0])]
    for relation in problem.relations:
        if (along := _along(relation, yaw_range_of)) is not None:
            candidates += RELATIONS[relation.kind].difference_axes(relation, along)
    directions: list[FloatArray] = []
    for direction in candidates:
        if all(abs(direction @ other) < 1.0 - 1e-12 for other in directions):
            directions.append(direction)
    return directions


def _fixed(frame: str, yaw_range_of: dict[str, YawCell]) -> float | None:
    low, high = yaw_range_of.get(frame, (0.0, np.inf))
    return low if high - low < 1e-9 else None


def _along(relation: SceneRelation, yaw_range_of: dict[str, YawCell]) -> FloatArray | None:
    """The direction of a relation in the frame of the root, None where it is not fixed."""
    turn = _fixed(relation.frame, yaw_range_of)
    return None if turn is None else turned(np.array([relation.direction]), turn)[0]


def _system(problem: Problem, root: str, yaw_range_of: dict[str, YawCell], d: FloatArray) -> DifferenceConstraints:
    system = DifferenceConstraints()
    related = _related(problem)
    things = [
        thing for thing in problem.things if thing.name in yaw_range_of and thing.name in related and thing.name != root
    ]
    node = {root: 0} | {thing.name: 3 * k + 1 for k, thing in enumerate(things)}
    for thing in things:
        _own_differences(system, thing, node, yaw_range_of, d)
        _place_differences(system, thing, node, yaw_range_of, d)
    for relation in problem.relations:
        if all(name in node and name != root for name in relation.things):
            _relation_differences(system, relation, node, yaw_range_of, d)
    if root == BACKGROUND and problem.reach is not None:
        base = turned((problem.reach.base_m - problem.X_WB[:3, 3])[None, :2], -background_yaw(problem))[0]
        reason = DifferenceReason("reach", "within reach", problem.reach.path)
        for name in related.intersection(problem.reach.members):
            system.add_lower_bound(0, node[name] + ORIGIN, float(base @ d) - problem.reach.most_m, reason)
            system.add_lower_bound(node[name] + ORIGIN, 0, -float(base @ d) - problem.reach.most_m, reason)
    return system


def _related(problem: Problem) -> set[str]:
    """Names of things in relations and of their owners; others are handled by `fits`."""
    owner = {thing.name: thing.parent for thing in problem.things}
    related: set[str] = set()
    for name in (name for relation in problem.relations for name in relation.things):
        while name in owner and name not in related:
            related.add(name)
            name = owner[name]
    return related


def _own_differences(
    system: DifferenceConstraints, thing: Thing, node: dict[str, int], yaw_range_of: dict[str, YawCell], d: FloatArray
) -> None:
    """Constraints between begin, origin and end of a footprint, over all orientations and yaws."""
    yaw, at, reason = (
        yaw_range_of[thing.name],
        node[thing.name],
        DifferenceReason("width", f"{thing.name} is that wide", thing.path),
    )
    outlines = [hull(stance.prisms) for stance in resting_orientations(thing)]
    front_low, front_high, back_low, back_high = np.array([support_bounds(outline, d, yaw) for outline in outlines]).T
    width = min(least_width(outline, d, yaw) for outline in outlines)
    system.add_lower_bound(at + BEGIN, at + END, width, reason)
    system.add_lower_bound(at + ORIGIN, at + END, float(front_low.min()), reason)
    system.add_lower_bound(at + END, at + ORIGIN, -float(front_high.max()), reason)
    system.add_lower_bound(at + BEGIN, at + ORIGIN, float(back_low.min()), reason)
    system.add_lower_bound(at + ORIGIN, at + BEGIN, -float(back_high.max()), reason)


def _place_differences(
    system: DifferenceConstraints, thing: Thing, node: dict[str, int], yaw_range_of: dict[str, YawCell], d: FloatArray
) -> None:
    """Constraints of the footprint on its place and of the origin in its ranges, relative to the owner's origin."""
    at, yaw = node[thing.name], yaw_range_of[thing.parent]
    owner = 0 if node[thing.parent] == 0 else node[thing.parent] + ORIGIN
    corner = thing.place.origin_P_m[:2]
    if not thing.domain.fixed_poses:
        _, front, _, back = support_bounds(area_hull(thing.place) + corner, d, yaw)
        on = DifferenceReason("support", f"{thing.name} on {thing.place.name}", thing.path)
        system.add_lower_bound(owner, at + BEGIN, -back, on)
        system.add_lower_bound(at + END, owner, -front, on)
    turn = _fixed(thing.parent, yaw_range_of)
    if turn is None:
        return
    local = turned(d[None], -turn)[0]
    if thing.domain.fixed_poses:
        along = [
            float(local @ (np.array([fixed_pose.x_m, fixed_pose.y_m]) + corner))
            for fixed_pose in thing.domain.fixed_poses
        ]
        written = DifferenceReason("range", f"{thing.name} in one of its places", thing.domain.path)
        system.add_lower_bound(owner, at + ORIGIN, min(along), written)
        system.add_lower_bound(at + ORIGIN, owner, -max(along), written)
        return
    low = high = float(local @ corner)
    axes = []
    for axis, (least, most) in enumerate((thing.domain.x_m, thing.domain.y_m)):
        if abs(local[axis]) > 1e-12:
            low, high = (
                low + min(local[axis] * least, local[axis] * most),
                high + max(local[axis] * least, local[axis] * most),
            )
            axes.append("xy"[axis])
    name = axes[0] if len(axes) == 1 else None
    path = (*thing.domain.path, name) if name else thing.domain.path
    within = DifferenceReason("range", f"{thing.name} in its range of {' and '.join(axes)}", path)
    system.add_lower_bound(owner, at + ORIGIN, low, within)
    system.add_lower_bound(at + ORIGIN, owner, -high, within)


def _relation_differences(
    system: DifferenceConstraints,
    relation: SceneRelation,
    node: dict[str, int],
    yaw_range_of: dict[str, YawCell],
    d: FloatArray,
) -> None:
    text = f"{relation.word or relation.kind}: [{', '.join(relation.as_written)}]"
    reason = DifferenceReason("relation", text, relation.path)
    at = [node[name] for name in relation.things]
    for u, point_u, v, point_v, least_m in RELATIONS[relation.kind].differences(
        relation, _along(relation, yaw_range_of), d
    ):
        system.add_lower_bound(at[u] + point_u, at[v] + point_v, least_m, reason)


def positive_cycle(system: DifferenceConstraints) -> list[int] | None:
    """Edges of a cycle whose sum is positive, in order, or None (Bellman-Ford, all nodes as sources, in rounds)."""
    u, v, w = np.array(system.u), np.array(system.v), np.array(system.w)
    count = int(max(u.max(), v.max())) + 1
    longest, last, order = np.zeros(count), np.full(count, -1), np.zeros(0, int)
    for _ in range(count + 1):
        candidate = longest[u] + w
        better = np.flatnonzero(candidate > longest[v] + 1e-12)
        if len(better) == 0:
            return None
        order = better[np.argsort(candidate[better], kind="stable")]
        longest[v[order]], last[v[order]] = candidate[order], order
    at = int(v[order[-1]])
    for _ in range(count):
        at = int(u[last[at]])
    start, cycle = at, []
    while not cycle or at != start:
        cycle.append(int(last[at]))
        at = int(u[last[at]])
    return cycle[::-1]


def _proof(system: DifferenceConstraints, cycle: list[int], direction: FloatArray) -> Proof:
    reasons, weights = [system.reasons[k] for k in cycle], np.array([system.w[k] + OUTLINE_SLACK_M for k in cycle])
    kinds = {reason.kind for reason in reasons}
    needed, room = float(weights[weights > 0.0].sum()), -float(weights[weights < 0.0].sum())
    axis = f"({direction[0]:g}, {direction[1]:g})"
    if kinds <= {"relation", "width"}:
        authored = tuple(reason for reason in reasons if reason.kind == "relation")
        excess = f"in a circle along {axis} they ask for {needed - room:.4g} m more"
        text = f"{_listed(authored)} contradict one another: {excess}"
        return Proof("relation-cycle", text, needed, room, "m", _paths(authored))
    things = [reason for reason in reasons if reason.kind == "width"]
    rest = [reason for reason in reasons if reason.kind != "width"]
    kind = "too-wide" if "relation" in kinds or len({r.path for r in things}) > 1 else "empty-region"
    text = f"{_listed(rest)} cannot hold together: along {axis} they ask for {needed:.4g} m, and there is {room:.4g} m"
    return Proof(kind, text, needed, room, "m", _paths((*rest, *things)))


def _listed(reasons: tuple[DifferenceReason, ...] | list[DifferenceReason]) -> str:
    return "; ".join(dict.fromkeys(reason.text for reason in reasons))


def _paths(reasons: tuple[DifferenceReason, ...] | list[DifferenceReason]) -> tuple[Path, ...]:
    return tuple(dict.fromkeys(reason.path for reason in reasons))
