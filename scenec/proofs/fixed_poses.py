"""Fixed poses: more things than usable poses.

Theorem (Hall 1935): things that exclude each other from the same poses can all be placed iff every set of them has at
least as many usable poses as members; a set with fewer is a proof.
"""

from __future__ import annotations

from itertools import combinations

import networkx as nx
import numpy as np

from geom.planar import turned
from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.fits import fixed_pose_usable
from scenec.proofs.outlines import OUTLINE_SLACK_M, hull, resting_orientations
from schemas.scene.geometry import FixedPose

Position = tuple[str, str, float, float, float]


def more_things_than_fixed_poses(problem: Problem) -> Proof | None:
    """A proof that names a set of things with fewer usable poses than members (maximum bipartite matching)."""
    things = [thing for thing in problem.things if thing.domain.fixed_poses]
    usable = {thing.name: _positions(problem, thing) for thing in things}
    exclusive = _exclusive_positions(things, usable)
    bound = [thing for thing in things if usable[thing.name] and set(usable[thing.name]) <= exclusive]
    if not bound:
        return None
    # Nodes are whole numbers, things first: the matching iterates over sets, where the order of strings is random.
    positions = sorted({position for thing in bound for position in usable[thing.name]})
    node_of = {position: len(bound) + k for k, position in enumerate(positions)}
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(bound)))
    graph.add_edges_from((k, node_of[p]) for k, thing in enumerate(bound) for p in sorted(usable[thing.name]))
    matching = nx.bipartite.hopcroft_karp_matching(graph, range(len(bound)))
    alone = next((k for k in range(len(bound)) if k not in matching), None)
    if alone is None:
        return None
    crowd = _alternating(graph, matching, alone)
    members = [thing for k, thing in enumerate(bound) if k in crowd]
    poses = {position for thing in members for position in usable[thing.name]}
    text = f"{', '.join(thing.name for thing in members)} share {len(poses)} usable places, {len(members)} are needed"
    paths = tuple(dict.fromkeys(thing.path for thing in members))
    return Proof("empty-domain", text, float(len(members)), float(len(poses)), "places", paths)


def _positions(problem: Problem, thing: Thing) -> dict[Position, list[FixedPose]]:
    by_position: dict[Position, list[FixedPose]] = {}
    for fixed_pose in thing.domain.fixed_poses:
        if fixed_pose_usable(problem, thing, fixed_pose):
            key = (thing.parent, thing.place.name, fixed_pose.x_m, fixed_pose.y_m, fixed_pose.z_m)
            by_position.setdefault(key, []).append(fixed_pose)
    return by_position


def _exclusive_positions(things: list[Thing], usable: dict[str, dict[Position, list[FixedPose]]]) -> set[Position]:
    """Positions at which any two things that may use them would overlap."""
    users: dict[Position, list[Thing]] = {}
    for thing in things:
        for position in usable[thing.name]:
            users.setdefault(position, []).append(thing)
    return {
        position
        for position, those in users.items()
        if all(_overlap(one, two, position, usable) for one, two in combinations(those, 2))
    }


def _overlap(one: Thing, two: Thing, position: Position, usable: dict[str, dict[Position, list[FixedPose]]]) -> bool:
    """Whether both footprints contain the origin of the position, hence overlap, at any orientation and yaw."""
    spans = [
        (-stance.origin_height_m, stance.height_m - stance.origin_height_m)
        for thing in (one, two)
        for stance in resting_orientations(thing)
    ]
    if min(high for _, high in spans) - max(low for low, _ in spans) <= OUTLINE_SLACK_M:
        return False
    return all(
        _covers_origin(hull(thing.body.resting_orientations[k].prisms), fixed_pose.yaw_rad)
        and len(thing.body.resting_orientations[k].prisms) == 1
        for thing in (one, two)
        for k in thing.domain.orientation_indices
        for fixed_pose in usable[thing.name][position]
    )


def _covers_origin(outline: np.ndarray, yaw_rad: float) -> bool:
    ring = turned(outline, yaw_rad)
    edges = np.roll(ring, -1, axis=0) - ring
    return bool((edges[:, 1] * ring[:, 0] - edges[:, 0] * ring[:, 1] > OUTLINE_SLACK_M * np.hypot(*edges.T)).all())


def _alternating(graph: nx.Graph[int], matching: dict[int, int], start: int) -> set[int]:
    """Things on alternating paths from an unmatched one: with their poses they violate Hall's condition."""
    seen, waiting = {start}, [start]
    while waiting:
        for position in graph[waiting.pop()]:
            other = matching[position]
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return seen
