"""Rule: the links of an articulation form one tree."""

from __future__ import annotations

from collections.abc import Iterator

import networkx as nx
from pxr import UsdPhysics

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-articulation",
    "The links form no tree",
    "Reduced-coordinate solvers refuse loops and nested roots; a link joined to nothing drops off.",
    "apply one articulation root, join every link, exclude loop closers from the articulation",
)
_WORLD = ""


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per nested or missing articulation root, per joint that closes a loop, per body joined to nothing."""
    roots = [prim for prim in subject.prims if prim.HasAPI(UsdPhysics.ArticulationRootAPI)]
    paths = [prim.GetPath() for prim in roots]
    for prim in roots:
        if any(prim.GetPath() != path and prim.GetPath().HasPrefix(path) for path in paths):
            yield finding(CODE, "an articulation root lies below another one", where=at(prim))
    if roots:
        yield from _loops(subject)
    if subject.released:
        yield from _package(subject, len(roots))


def _loops(subject: Subject) -> Iterator[Diagnostic]:
    """Reduced-coordinate solvers take trees; the joint that closes a loop must be excluded from the articulation."""
    tree = nx.Graph()
    for joint in subject.joints:
        if not (joint.enabled and joint.in_articulation and joint.bodies):
            continue
        first, second = (side.body.path if side.body is not None else _WORLD for side in joint.sides)
        if first == second:
            continue  # Reported by the joint-bodies rule.
        if first in tree and second in tree and nx.has_path(tree, first, second):
            headline = "the joint closes a loop of the articulation"
            bound = "excludeFromArticulation"
            yield finding(CODE, headline, where=at(joint.prim), bound=bound, severity=subject.suspect_severity)
        tree.add_edge(first, second)


def _package(subject: Subject, roots: int) -> Iterator[Diagnostic]:
    where = at(subject.root)
    if len(subject.bodies) == 1 and roots:
        yield finding(CODE, "a single body is marked as an articulation", where=where, severity=Severity.WARNING)
    if len(subject.active_bodies) < 2:
        return
    if not roots:
        yield finding(CODE, "several bodies, but no articulation root", where=where)
    linked = nx.Graph()
    linked.add_nodes_from(body.path for body in subject.active_bodies)
    linked.add_edges_from(
        (joint.bodies[0].path, joint.bodies[1].path) for joint in subject.joints if len(joint.bodies) == 2
    )
    components = sorted(nx.connected_components(linked), key=len, reverse=True)
    for path in sorted(path for component in components[1:] for path in component if path in linked):
        headline = "the link is joined to none of the others"
        yield finding(CODE, headline, where=at(subject.stage.GetPrimAtPath(path)))


RULE = Rule(CODE, "one root, one tree; loops excluded from the articulation", "UsdPhysicsArticulationRootAPI", check)
