"""Rule: the convex colliders of two links do not overlap at rest."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import networkx as nx

from gate.rules.rule import Rule
from gate.subject import Body, Joint, Subject
from gate.subject.filters import filtered_pair, may_collide
from gate.subject.overlap import deepest_penetration, hulls_along_motion, hulls_of
from gate.subject.values import at
from geom.convex.penetration import shared_volume
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Label, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-links-overlap",
    "Links occupy the same space at rest",
    "They burst apart in the first step, or never move.",
    "move the links apart, shrink their colliders, or filter pairs that are meant to overlap",
)
REST_LEAST_M, REST_LEAST_SHARE = 2e-3, 0.01  # of the smaller diagonal: what fitted hulls are off by
SWALLOWED = 0.5  # of the smaller body's volume
REST_THROUGH = 0.5  # of the thinner hull: a joint housing stays well below, a board stuck in another one does not
_RANGE_SHARES = (0.25, 0.5, 1.0)  # of the way to each limit
_MOST_TESTS = 20_000  # hull pairs; a heavier file is not judged to the end


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per two links whose convex colliders overlap deeper than fitted hulls do.

    Links welded by fixed joints may overlap. For links that share a moving joint only the overlap that the joint's
    motion can undo counts: a housing overlaps its shaft wherever that turns, a drawer that sticks in the back wall
    comes free when pulled. Only a warning are links that a filtered pair names: the author means them to overlap.
    """
    welded = _welded(subject)
    movers = {frozenset((welded[a.path], welded[b.path])): joint for joint, a, b in _moving(subject)}
    tests = 0
    for first, second in combinations(subject.active_bodies, 2):
        if welded[first.path] == welded[second.path]:
            continue
        tests += len(first.active_colliders) * len(second.active_colliders)
        if tests > _MOST_TESTS:
            return
        joint = movers.get(frozenset((welded[first.path], welded[second.path])))
        yield from _pair(subject, first, second, joint)


def _pair(subject: Subject, first: Body, second: Body, joint: Joint | None) -> Iterator[Diagnostic]:
    hulls_a, hulls_b = hulls_of(first), hulls_of(second)
    bound_m = max(REST_LEAST_M, REST_LEAST_SHARE * min(first.diagonal_m, second.diagonal_m))
    depth_m, thickness_m = deepest_penetration(hulls_a, hulls_b)
    if depth_m <= bound_m or first.collider_volume is None or second.collider_volume is None:
        return
    smaller = min(first.collider_volume.volume_m3, second.collider_volume.volume_m3)
    share = sum(shared_volume(a.points, b.points) for a in hulls_a for b in hulls_b) / smaller
    swallowed = share > SWALLOWED
    if joint is not None:
        depth_m -= min(
            (
                deepest_penetration(hulls_a, moved)[0]
                for _, moved in hulls_along_motion(joint, second, hulls_b, _RANGE_SHARES)
            ),
            default=depth_m,
        )
        if depth_m <= bound_m and not swallowed:
            return
    through = joint is not None and depth_m > REST_THROUGH * thickness_m
    yield finding(
        CODE,
        f"the link {'lies inside or around' if swallowed else 'overlaps'} {second.path} at rest",
        where=at(first.prim),
        value=share if swallowed else depth_m,
        bound=SWALLOWED if swallowed else bound_m,
        unit="of its volume" if swallowed else "m",
        labels=(Label(where=at(second.prim), text="the other link"),),
        severity=subject.suspect_severity
        if not filtered_pair(first, second) and (swallowed or through or may_collide(first, second, joint))
        else Severity.WARNING,
    )


def _moving(subject: Subject) -> Iterator[tuple[Joint, Body, Body]]:
    for joint in subject.joints:
        if joint.enabled and joint.kind != "fixed" and len(joint.bodies) == 2:
            yield joint, joint.bodies[0], joint.bodies[1]


def _welded(subject: Subject) -> dict[str, int]:
    """Body path -> number of the group of bodies that fixed joints make one."""
    graph = nx.Graph()
    graph.add_nodes_from(body.path for body in subject.active_bodies)
    for joint in subject.joints:
        if joint.enabled and joint.kind == "fixed" and len(joint.bodies) == 2:
            graph.add_edge(joint.bodies[0].path, joint.bodies[1].path)
    return {path: number for number, group in enumerate(nx.connected_components(graph)) for path in group}


RULE = Rule(
    CODE,
    "depth <= 2 mm or 1 % of the smaller link; half of its volume for links that share a joint",
    "exact penetration depth of convex hulls (Minkowski difference)",
    check,
)
