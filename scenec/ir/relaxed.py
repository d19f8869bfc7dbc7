"""Relaxes a problem by dropping authored constraints, which are named by their paths in the program."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from scenec.ir.problem import Problem, Thing
from source.tree import Path

ANYWHERE = (-np.inf, np.inf)
WHOLE_TURN = (-np.pi, np.pi)
CLEARANCE: Path = ("clearance",)


def rules(problem: Problem) -> tuple[Path, ...]:
    """Paths of the authored constraints: relations, ranges by axis, keep-outs, spaces kept
    clear, reach, clearance; in that order."""
    ranges: list[Path] = []
    for thing in problem.things:
        if not thing.domain.fixed_poses:
            free = (thing.domain.x_m == ANYWHERE, thing.domain.y_m == ANYWHERE, any_heading(thing.domain.yaw_rad))
            axes = zip(("x", "y", "yaw"), free, strict=True)
            ranges += [(*thing.domain.path, axis) for axis, is_free in axes if not is_free]
    reach = (problem.reach.path,) if problem.reach is not None else ()
    clearance = (CLEARANCE,) if problem.clearance_m > 0.0 else ()
    relations = [relation.path for relation in problem.relations]
    keep_outs = [rule.path for rule in (*problem.keep_outs, *problem.keep_clear)]
    return tuple(dict.fromkeys((*relations, *ranges, *keep_outs, *reach, *clearance)))


def nodes(problem: Problem) -> tuple[Path, ...]:
    """Paths of the things themselves (copies of one node share theirs)."""
    return tuple(dict.fromkeys(thing.path for thing in problem.things))


def any_heading(yaw_rad: tuple[float, float]) -> bool:
    """Whether a range of headings is a whole turn."""
    return yaw_rad[1] - yaw_rad[0] > 2.0 * np.pi - 1e-9


def relaxed(problem: Problem, dropped: Collection[Path]) -> Problem:
    """The problem without the constraints at these paths. A dropped thing takes along all things on it and all
    relations that name it; a dropped range is free along its axis; clearance becomes 0, but footprints still may not
    overlap."""
    gone = set(dropped)
    away = _away(problem, gone)
    things = tuple(_freed(thing, gone) for thing in problem.things if thing.name not in away)
    reach = problem.reach
    if reach is not None:
        members = tuple(name for name in reach.members if name not in away)
        reach = None if reach.path in gone or not members else replace(reach, members=members)
    return replace(
        problem,
        things=things,
        relations=tuple(
            relation
            for relation in problem.relations
            if relation.path not in gone and not away & {*relation.things, relation.frame}
        ),
        keep_outs=tuple(rule for rule in problem.keep_outs if rule.path not in gone and rule.parent not in away),
        keep_clear=tuple(rule for rule in problem.keep_clear if rule.path not in gone and rule.owner not in away),
        reach=reach,
        stacks=tuple(stack for stack in problem.stacks if away.isdisjoint(stack)),
        clearance_m=0.0 if CLEARANCE in gone else problem.clearance_m,
    )


def _away(problem: Problem, gone: set[Path]) -> set[str]:
    """Names of the things dropped, and of all that stands on them."""
    away = {thing.name for thing in problem.things if thing.path in gone}
    while more := {t.name for t in problem.things if t.parent in away} - away:
        away |= more
    return away


def _freed(thing: Thing, gone: set[Path]) -> Thing:
    domain = thing.domain
    if domain.fixed_poses:
        return thing
    x = ANYWHERE if (*domain.path, "x") in gone else domain.x_m
    y = ANYWHERE if (*domain.path, "y") in gone else domain.y_m
    yaw = WHOLE_TURN if (*domain.path, "yaw") in gone else domain.yaw_rad
    return replace(thing, domain=replace(domain, x_m=x, y_m=y, yaw_rad=yaw))
