"""Coupling of things: components that must be solved jointly, and stricter relations that keep components
independent."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, inf, pi, sin

import networkx as nx
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from scenec.relations.table import RELATIONS
from scenec.solve.model import Limit, SolverModel
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import BACKGROUND, SceneRelation

YAW_SAMPLES = 64


def footprint_bounds(model: SolverModel, name: str) -> tuple[float, float, float, float]:
    """Box (x0, y0, x1, y1) in P that contains the footprint of a thing over its whole domain."""
    thing = model.things[name]
    site = model.site(thing)
    a0, b0, a1, b1 = site.bounds
    ox, oy = float(thing.place.origin_P_m[0]), float(thing.place.origin_P_m[1])
    low, high = thing.domain.yaw_rad
    shapes = [
        model.shapes[name][stance] for stance in thing.domain.orientation_indices if stance < len(model.shapes[name])
    ]
    if not shapes:
        return a0, b0, a1, b1
    if thing.domain.fixed_poses:
        bounds_at = [
            (fixed_pose, shape.turned(fixed_pose.yaw_rad).bounds)
            for shape in shapes
            for fixed_pose in thing.domain.fixed_poses
        ]
        boxes = [
            (fixed_pose.x_m + ox + x0, fixed_pose.y_m + oy + y0, fixed_pose.x_m + ox + x1, fixed_pose.y_m + oy + y1)
            for fixed_pose, (x0, y0, x1, y1) in bounds_at
        ]
        x0s, y0s, x1s, y1s = zip(*boxes, strict=True)
        return min(x0s), min(y0s), max(x1s), max(y1s)
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    if low == high:
        x0s, y0s, x1s, y1s = zip(*(shape.turned(low).bounds for shape in shapes), strict=True)
        x0, y0, x1, y1 = min(x0s), min(y0s), max(x1s), max(y1s)
    else:
        x1 = y1 = max(shape.radius_m for shape in shapes)
        x0 = y0 = -x1
    return max(xa + ox + x0, a0), max(ya + oy + y0, b0), min(xb + ox + x1, a1), min(yb + oy + y1, b1)


def heights(model: SolverModel, name: str) -> tuple[float, float]:
    """Lowest and highest z in P of a thing with all it carries, over its domain."""
    thing = model.things[name]
    base = model.site(thing).base_P_m
    shapes = model.shapes[name]
    lows = [fixed_pose.z_m - shape.origin_height_m for fixed_pose in thing.domain.fixed_poses for shape in shapes] or [
        0.0
    ]
    high = max(lows) + max(shape.height_m for shape in shapes)
    if thing.place.is_volume and not thing.domain.fixed_poses:
        high = max(high, thing.place.height_m)  # on other contents
    return base + min(lows), base + high


def overlapping(model: SolverModel) -> list[tuple[str, str]]:
    """Pairs of things of one owner whose footprints, grown by the clearance, may overlap at common heights."""
    return [
        (names[i], names[j])
        for names, near in _near_by_owner(model)
        for i, j in zip(*np.nonzero(np.triu(near, 1)), strict=True)
    ]


def _near_by_owner(model: SolverModel) -> list[tuple[list[str], BoolArray]]:
    # For each owner: names of the things on it, and which of them may meet, (n, n).
    siblings: dict[str, list[str]] = defaultdict(list)
    for name, thing in model.things.items():
        siblings[thing.parent].append(name)
    owners = []
    for names in siblings.values():
        box = np.array([footprint_bounds(model, name) for name in names])
        height = np.array([heights(model, name) for name in names])
        low, high = np.column_stack([box[:, :2], height[:, 0]]), np.column_stack([box[:, 2:], height[:, 1]])
        near = boxes_may_meet(low, high, model.problem.clearance_m)
        owners.append((names, near))
    return owners


def boxes_may_meet(low_m: FloatArray, high_m: FloatArray, clearance_m: float) -> BoolArray:
    """(n, n) which boxes (n, 3) have a common height and are closer than the clearance in the plane."""
    near = np.ones((len(low_m), len(low_m)), dtype=bool)
    for axis, room in ((0, clearance_m), (1, clearance_m), (2, 0.0)):
        low, high = low_m[:, axis], high_m[:, axis]
        near &= (low[:, None] < high[None, :] + room) & (low[None, :] < high[:, None] + room)
    return near


def components_of(model: SolverModel) -> tuple[tuple[str, ...], ...]:
    """Names of the things of each joint component, sorted; components are sorted by their first name."""
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(model.things)
    for names, near in _near_by_owner(model):
        labels = [0] * len(names)
        if not near.all():
            labels = connected_components(csr_array(near), directed=False)[1].tolist()
        first: dict[int, str] = {}
        for name, label in zip(names, labels, strict=True):
            graph.add_edge(first.setdefault(label, name), name)
    for rule in model.rules:
        if not RELATIONS[rule.kind].separable or not model.in_one_frame(rule):
            graph.add_edges_from(pairwise(sorted(model.depends_on(rule))))
    if model.problem.reach is not None:
        for name in model.problem.reach.members:
            graph.add_edges_from(pairwise(model.chains.get(name, ())))
    return tuple(sorted(tuple(sorted(members)) for members in nx.connected_components(graph)))


def lifted(model: SolverModel, rule: SceneRelation) -> SceneRelation:
    """A stricter relation between siblings that implies one across owners: contents of a tray are left of a box when
    the tray is, wherever they are on the tray. The relation itself where there is no such."""
    meaning = RELATIONS[rule.kind]
    if not meaning.lifts_to_owners or model.in_one_frame(rule):
        return rule
    chains = [(BACKGROUND, *model.chains[name]) for name in rule.things]
    depth = 0
    while depth < min(len(chain) for chain in chains) and chains[0][depth] == chains[1][depth]:
        depth += 1
    owner = chains[0][depth - 1]
    if any(len(chain) <= depth for chain in chains) or (meaning.frame_dependent and rule.frame != owner):
        return rule
    return replace(rule, things=(chains[0][depth], chains[1][depth]))


def separating_limits(
    model: SolverModel, components: tuple[tuple[str, ...], ...]
) -> dict[str, tuple[Limit, ...]] | None:
    """Limits by name of thing that imply every directional relation between different components: for each such
    relation one coordinate before which its first member ends and after which its second begins. None where there is no
    room."""
    home = {name: k for k, members in enumerate(components) for name in members}
    limits: dict[str, list[Limit]] = defaultdict(list)
    for rule in model.rules:
        if not RELATIONS[rule.kind].separable or home[rule.things[0]] == home[rule.things[1]]:
            continue
        dx, dy = rule.direction
        first, second = (_span(footprint_bounds(model, name), dx, dy) for name in rule.things)
        if first[1] + rule.gap_m <= second[0]:
            continue
        widths = [_least_width(model, name, dx, dy) for name in rule.things]
        earliest, latest = first[0] + widths[0], second[1] - widths[1] - rule.gap_m
        if earliest > latest:
            return None
        # In the middle both have the same room, as far as their ranges allow.
        middle = min(max((earliest + latest) / 2, earliest), latest)
        limits[rule.things[0]].append(Limit(dx, dy, middle))
        limits[rule.things[1]].append(Limit(-dx, -dy, -middle - rule.gap_m))
    return {name: tuple(limits_of_thing) for name, limits_of_thing in limits.items()}


def _span(box: tuple[float, float, float, float], dx: float, dy: float) -> tuple[float, float]:
    along = [x * dx + y * dy for x in (box[0], box[2]) for y in (box[1], box[3])]
    return min(along), max(along)


def _least_width(model: SolverModel, name: str, dx: float, dy: float) -> float:
    # Least extent of the footprint along a direction over the allowed yaws (sampled; it only positions a limit).
    thing, least = model.things[name], inf
    low, high = thing.domain.yaw_rad
    for shape in model.shapes[name]:
        for yaw in np.linspace(low, high, YAW_SAMPLES if high > low else 1).tolist():
            c, s = cos(yaw), sin(yaw)
            along = shape.hull @ (c * dx + s * dy, -s * dx + c * dy)
            least = min(least, float(np.ptp(along)))
    return least if least < inf else hypot(pi, pi)
