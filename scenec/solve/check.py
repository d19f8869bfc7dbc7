"""Incremental validation of assignments: each test returns the names of the things it depends on, for backjumping."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import shapely

from scenec.relations.table import RELATIONS
from scenec.solve.frames import pose_of
from scenec.solve.measures import SLACK, wrapped
from scenec.solve.model import Site, SolverModel, yaw_allowed
from scenec.solve.placed import Placed, bounds_gap, footprint_distance
from scenec.solve.planar import SLACK_M
from scenec.solve.stacks import stacked, unsupported

Assignment = Mapping[str, Placed]


def fits_alone(model: SolverModel, placed: Placed) -> bool:
    """Whether a thing satisfies its unary constraints: domain, place, parts of the owner, keep-outs, limits."""
    thing = model.things[placed.name]
    domain, placement = thing.domain, placed.placement
    if placement.stance not in model.allowed_orientations(thing):
        return False
    if domain.fixed_poses:
        height = placed.turned.shape.origin_height_m
        if not any(
            fixed_pose.stance == placement.stance
            and abs(fixed_pose.x_m - placement.x_m) <= SLACK_M
            and abs(fixed_pose.y_m - placement.y_m) <= SLACK_M
            and abs(fixed_pose.z_m - height - placement.base_m) <= SLACK_M
            and abs(wrapped(fixed_pose.yaw_rad - placement.yaw_rad)) <= SLACK_M
            for fixed_pose in domain.fixed_poses
        ):
            return False
    elif (
        yaw_allowed(placement.yaw_rad, domain.yaw_rad) is None
        or not domain.x_m[0] - SLACK_M <= placement.x_m <= domain.x_m[1] + SLACK_M
        or not domain.y_m[0] - SLACK_M <= placement.y_m <= domain.y_m[1] + SLACK_M
    ):
        return False
    for dx, dy, end in model.limits.get(placed.name, ()):
        at = placed.x_P_m * dx + placed.y_P_m * dy
        if at + float((placed.turned.hull @ (dx, dy)).max()) > end + SLACK_M:
            return False
    return on_site(placed, model.site(thing))


def on_site(placed: Placed, site: Site) -> bool:
    """Whether a thing is inside the polygon of each layer that it spans, below the top, clear of parts and
    keep-outs."""
    base, shape = placed.placement.base_m, placed.turned.shape
    # Things carried by contents of a receptacle may rise over its rim; under a shelf board nothing may.
    height_m = shape.height_m if site.is_surface else max(prism.high_m for prism in shape.prisms[: shape.own])
    if base < -SLACK_M or base + height_m > site.top_m + SLACK_M:
        return False
    in_air = base > SLACK_M and site.is_surface  # a fixed pose off the floor is accepted as authored
    for k, (low, high, layer) in enumerate(() if in_air else site.layers):
        if len(site.layers) == 1 and site.is_box:
            x0, y0, x1, y1 = placed.bounds
            a0, b0, a1, b1 = layer.bounds
            if min(x0 - a0, y0 - b0, a1 - x1, b1 - y1) < -SLACK_M:
                return False
        elif len(site.layers) == 1:
            if not all(site.grown_layers[k].covers(piece) for piece in placed.footprint):
                return False
        else:
            for outline, prism_low, prism_high in placed.prisms:
                spans = prism_low - site.base_P_m < high - SLACK_M and prism_high - site.base_P_m > low + SLACK_M
                if spans and not site.grown_layers[k].covers(outline):
                    return False
    for outline, low, high in site.above:
        for prism, prism_low, prism_high in placed.prisms:
            if prism_low < high - SLACK_M and prism_high > low + SLACK_M and _overlap(prism, outline):
                return False
    return not any(
        prism_low < high - SLACK_M and prism_high > low + SLACK_M and _overlap(prism, polygon)
        for polygon, low, high in site.keep_outs
        for prism, prism_low, prism_high in placed.prisms
    )


def _overlap(a: shapely.Polygon, b: shapely.Polygon) -> bool:
    # Whether they still intersect when each is eroded by half of the slack; a test by area would miss corners.
    if not a.intersects(b):
        return False
    less_a, less_b = (part.buffer(-SLACK_M / 2.0, join_style="mitre") for part in (a, b))
    return bool(less_a.intersects(less_b))


def _too_close(a: shapely.Polygon, b: shapely.Polygon, clearance_m: float) -> bool:
    # Without clearance the distance is no test: it is 0 both where they touch and where they overlap.
    return _overlap(a, b) if clearance_m <= SLACK_M else bool(a.distance(b) < clearance_m - SLACK_M)


def clash(a: Placed, b: Placed, clearance_m: float) -> bool:
    """Whether two things on the same owner come closer than the clearance at heights they share."""
    if bounds_gap(a, b) >= clearance_m - SLACK_M:
        return False
    if not (a.base_P_m < b.top_P_m - SLACK_M and b.base_P_m < a.top_P_m - SLACK_M):
        return False
    if a.place == b.place:
        if clearance_m > SLACK_M:
            return footprint_distance(a, b) < clearance_m - SLACK_M
        return any(_overlap(p, q) for p in a.footprint for q in b.footprint)
    return any(
        low_a < high_b - SLACK_M and low_b < high_a - SLACK_M and _too_close(p, q, clearance_m)
        for p, low_a, high_a in a.prisms
        for q, low_b, high_b in b.prisms
    )


def in_reach(model: SolverModel, name: str, assignment: Assignment) -> bool:
    """Whether the asset origin of a placed thing is within the robot's reach ring, in the ground plane of the world."""
    reach = model.problem.reach
    if reach is None or name not in reach.members:
        return True
    pose = pose_of(name, assignment)
    p_W = (model.problem.X_WB @ (pose.x_m, pose.y_m, pose.z_m, 1.0))[:3]
    return reach.least_m - SLACK_M <= float(np.hypot(*(p_W - reach.base_m)[:2])) <= reach.most_m + SLACK_M


def blockers(
    model: SolverModel, assignment: Assignment, name: str, mates: Iterable[str] | None = None
) -> set[str] | None:
    """None where `name` is consistent with all placed things; else the things it clashes with (empty: its own domain).

    `mates` are the only things that can come too close, where known to the caller.
    """
    placed = assignment[name]
    if not fits_alone(model, placed):
        return set()
    clearance = model.problem.clearance_m
    culprits: set[str] = set()
    for other in assignment if mates is None else mates:
        mate = assignment[other]
        if mate.parent == placed.parent and other != name and clash(placed, mate, clearance):
            culprits.add(other)
    for rule in model.rules_of.get(name, ()):
        links = model.depends_on(rule)
        if links.issubset(assignment) and RELATIONS[rule.kind].excess(rule, assignment) > SLACK:
            culprits |= links
    if (down := unsupported(model, assignment, placed.parent, placed.place)) and not culprits:
        return down - {name}
    chain = set(model.chains[name])
    if not culprits and chain.issubset(assignment) and not in_reach(model, name, assignment):
        return chain - {name}
    return culprits - {name} if culprits else None


def invalid_things(
    model: SolverModel, assignment: Assignment, suspects: Iterable[str] | None = None
) -> dict[str, set[str]]:
    """Invalid things of an assignment, each with the things it clashes with; empty for a valid assignment. With
    `suspects` only faults that involve one of them are searched."""
    # Stacked things depend on others.
    checked = assignment if suspects is None else {*suspects, *stacked(model, assignment)}
    names = [name for name in assignment if name in checked]
    mates = _close(model, assignment, names)
    causes = {}
    for name in names:
        if (cause := blockers(model, assignment, name, mates[name])) is not None:
            causes[name] = cause
    return causes


def _close(model: SolverModel, assignment: Assignment, names: Sequence[str]) -> dict[str, list[str]]:
    # For each of `names` the things on the same owner whose bounding boxes are closer than the clearance.
    everyone = list(assignment)
    box = np.array([assignment[name].bounds for name in everyone]).reshape(-1, 4)
    owner = {parent: k for k, parent in enumerate(sorted({placed.parent for placed in assignment.values()}))}
    owners = np.array([owner[assignment[name].parent] for name in everyone])
    index = {name: k for k, name in enumerate(everyone)}
    rows = [index[name] for name in names]
    mine, clearance = box[rows], model.problem.clearance_m
    near = owners[rows][:, None] == owners[None, :]
    for low, high in ((0, 2), (1, 3)):
        near &= mine[:, low, None] < box[None, :, high] + clearance
        near &= box[None, :, low] < mine[:, high, None] + clearance
    near[np.arange(len(rows)), rows] = False
    return {name: [everyone[k] for k in np.flatnonzero(near[i]).tolist()] for i, name in enumerate(names)}
