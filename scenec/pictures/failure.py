"""Draws why there is no scene, projected onto the ground: the place, free regions of the things concerned, the
conflict."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence

import numpy as np
import shapely
from matplotlib.axes import Axes
from shapely.affinity import translate
from shapely.geometry.base import BaseGeometry

from render.figure import png
from scenec.ir.problem import Exhausted, Infeasible, Problem, Result, Thing
from scenec.pictures.blockers import footprint, footprint_at, obstructing_things, owner_parts
from scenec.pictures.canvas import CLEAR, EDGE, FREE, INK, SUPPORT, THINGS, WRONG, area, name, sheet
from scenec.pictures.relations import draw_relations
from scenec.proofs.swept_spaces import certain_spaces
from scenec.solve.check import Assignment
from scenec.solve.model import SolverModel, model_of
from scenec.solve.regions import feasible_region, region_alone
from schemas.arrays import FloatArray
from schemas.scene.geometry import SceneRelation
from source.tree import Path, written

_CAPTION = 105  # characters a line
_MOST_LINES = 9
_TILT_RAD = 0.6  # apart in x and y: ranges may leave one of them
_MOST_WAITING = 6  # things without a place that are drawn


def failure(problem: Problem, result: Result, paths: Sequence[Path] = (), chosen: str = "") -> bytes:
    """PNG of the place where the conflict is, in the frame of its anchor; `paths` are the conflicting constraints, and
    `chosen` is the combination as text.

    Green is the free region of the origin of a thing by itself (place, ranges, keep-outs); dashed outlines are its
    footprint, red are the conflicting constraints. Things are drawn apart where nothing fixes their position. Grey are
    obstacles in any case: parts of the owner, things with one pose. After an exhausted search grey is the best partial
    assignment, and green is the region that it leaves.
    """
    names = _involved(problem, result, paths)
    stood = result.best_placements if isinstance(result, Exhausted) else {}
    stood = {name: at for name, at in stood.items() if name != _failing(result)}
    things = [thing for thing in problem.things if thing.name in names and thing.name not in stood]
    (parent, anchor), _ = Counter((t.parent, t.place.name) for t in things or problem.things).most_common(1)[0]
    here = [t for t in things or problem.things if (t.parent, t.place.name) == (parent, anchor)]
    place = here[0].place
    outline = place.polygon
    bounds = np.array(outline.bounds)
    caption = _caption(problem, result, paths)
    picture, axes = sheet(bounds[:2], bounds[2:], _title(problem, result, chosen), len(caption))
    area(axes, outline, order=1.0, facecolor=SUPPORT, edgecolor=EDGE, linewidth=1.2)
    for rule in problem.keep_outs:
        if (rule.parent, rule.place.name) == (parent, anchor):
            area(axes, rule.polygon, order=1.5, facecolor="none", edgecolor=WRONG, hatch="///", alpha=0.5)
    for space in next((spaces for thing in here if (spaces := certain_spaces(problem, thing))), ()):
        area(axes, space.area, order=1.5, facecolor="none", edgecolor=WRONG, hatch="...", alpha=0.5)
    for part in owner_parts(problem, parent, anchor):
        area(axes, part, order=1.6, facecolor=CLEAR, edgecolor=INK, hatch="xxx", linewidth=0.6, alpha=0.5)
    model = model_of(problem)
    placed = {name: model.put(name, at) for name, at in stood.items()}
    ghosts = _ghosts(model, here, outline, placed)
    blocked = [(t, at) for t, at in obstructing_things(problem, result, parent, anchor) if t.name not in ghosts]
    for thing, at in blocked:
        area(axes, footprint(thing, at), order=2.2, facecolor=CLEAR, edgecolor=INK, linewidth=0.8, alpha=0.55)
        name(axes, np.array([at.x_m, at.y_m]), thing.name, order=5.5, size=7.0)
    for index, thing in enumerate(here):
        _draw(axes, model, thing, ghosts[thing.name], THINGS[index % len(THINGS)])
    clashing = {path[1] for path in paths if path[:1] == ("relations",) and len(path) > 1}
    middles = {t.name: np.array([at.x_m, at.y_m]) for t, at in blocked} | {n: ghost[0] for n, ghost in ghosts.items()}
    shown = [r for r in problem.relations if not clashing or _index(r) in clashing]
    colour = WRONG if clashing else CLEAR
    draw_relations(axes, shown, middles, lambda _: colour, order=5.0, numbered=True)
    axes.set_xlabel(f"x of {anchor} (m)")
    axes.set_ylabel(f"y of {anchor} (m)")
    picture.supxlabel("\n".join(caption), x=0.02, ha="left", fontsize=8, color=INK)
    return png(picture)


def _involved(problem: Problem, result: Result, paths: Sequence[Path]) -> set[str]:
    """Names of the things in the conflicting constraints; after an exhausted search those related to the thing that
    failed most, and some that were never placed."""
    names = set[str]()
    if isinstance(result, Exhausted):
        names = {result.blocking}.union(*(r.things for r in problem.relations if result.blocking in r.things))
        waiting = [thing.name for thing in problem.things if thing.name not in result.best_placements]
        names |= set(waiting[:_MOST_WAITING])
    for path in paths:
        for relation in problem.relations:
            if relation.path and path[: len(relation.path)] == relation.path:
                names |= set(relation.things)
        for thing in problem.things:
            if (thing.path and path[: len(thing.path)] == thing.path) or (
                thing.group is not None and path[:3] == ("layout", "groups", thing.group)
            ):
                names.add(thing.name)
    return names


def _title(problem: Problem, result: Result, chosen: str) -> str:
    among = f"\nwith {chosen}" if chosen else ""
    if isinstance(result, Exhausted):
        if result.note:
            return f"{problem.scene}: not found{among}"
        return f"{problem.scene}: not found in {result.steps} steps; {result.blocking} failed most{among}"
    return f"{problem.scene}: there is no such scene{among}"


def _caption(problem: Problem, result: Result, paths: Sequence[Path]) -> list[str]:
    lines = []
    if isinstance(result, Infeasible):
        lines = textwrap.wrap(result.proof.text, _CAPTION)
    elif isinstance(result, Exhausted) and result.note:
        lines = textwrap.wrap(result.note, _CAPTION)
    elif isinstance(result, Exhausted):
        lines = [f"{result.placed} of {result.of} things could be placed at best (grey); green is what they leave"]
    words = {relation.path: relation for relation in problem.relations}
    for path in paths:
        relation = words.get(path)
        authored = f": {' '.join([relation.word or relation.kind, *relation.as_written])}" if relation else ""
        lines.append(f"- {written(path)}{authored}")
    return lines if len(lines) <= _MOST_LINES else [*lines[:_MOST_LINES], f"... and {len(lines) - _MOST_LINES} more"]


def _failing(result: Result) -> str | None:
    return result.blocking if isinstance(result, Exhausted) else None


def _ghosts(
    model: SolverModel, things: Sequence[Thing], outline: BaseGeometry, placed: Assignment
) -> dict[str, tuple[FloatArray, BaseGeometry]]:
    """By name: the point in A at which to draw the footprint, and the free region of its origin in A."""
    x0, y0, x1, y1 = outline.bounds
    centre, radius = np.array([x0 + x1, y0 + y1]) / 2.0, 0.3 * np.array([x1 - x0, y1 - y0])
    ghosts: dict[str, tuple[FloatArray, BaseGeometry]] = {}
    for index, thing in enumerate(things):
        region = _free(model, thing, placed)
        angle = 2.0 * np.pi * index / max(len(things), 1) + np.pi + _TILT_RAD
        apart = centre + radius * np.array([np.cos(angle), np.sin(angle)]) * (len(things) > 1)
        at = _within(thing, apart)
        if not region.is_empty:
            near = shapely.shortest_line(region, shapely.Point(at))
            at = np.array(near.coords[0])
        ghosts[thing.name] = at, region
    return ghosts


def _within(thing: Thing, point: FloatArray) -> FloatArray:
    """The point of the thing's ranges nearest to `point`."""
    low = np.array([thing.domain.x_m[0], thing.domain.y_m[0]])
    high = np.array([thing.domain.x_m[1], thing.domain.y_m[1]])
    if thing.domain.fixed_poses:
        points_A_m = np.array([[fixed_pose.x_m, fixed_pose.y_m] for fixed_pose in thing.domain.fixed_poses])
        return points_A_m[np.argmin(np.linalg.norm(points_A_m - point, axis=1))]
    return np.clip(point, low, high)


def _yaw_rad(thing: Thing) -> float:
    """The allowed yaw nearest to 0."""
    if thing.domain.fixed_poses:
        return thing.domain.fixed_poses[0].yaw_rad
    return float(np.clip(0.0, *thing.domain.yaw_rad))


def _free(model: SolverModel, thing: Thing, placed: Assignment) -> BaseGeometry:
    """Free region of the origin in A at the drawn yaw, given the placed things."""
    if thing.domain.fixed_poses:
        return shapely.MultiPoint([(fixed_pose.x_m, fixed_pose.y_m) for fixed_pose in thing.domain.fixed_poses])
    turned = model.shapes[thing.name][thing.domain.orientation_indices[0]].turned(_yaw_rad(thing))
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    return translate(
        feasible_region(model, thing.name, turned, placed, region_alone(model, thing.name, turned))[0], -ox, -oy
    )


def _draw(axes: Axes, model: SolverModel, thing: Thing, ghost: tuple[FloatArray, BaseGeometry], colour: str) -> None:
    at, region = ghost
    area(axes, region, order=2.0, facecolor=FREE, edgecolor=FREE, alpha=0.13, linewidth=0.8)
    wrong = region.is_empty
    shape = footprint_at(thing, thing.domain.orientation_indices[0], _yaw_rad(thing), at)
    edge = WRONG if wrong else INK
    area(axes, shape, order=3.0, facecolor=colour, edgecolor=edge, linestyle="--", linewidth=1.1, alpha=0.6)
    words = f"{thing.name}: no room" if wrong else thing.name
    name(axes, at, words, order=6.0, color=edge)
    _draw_ranges(axes, thing)


def _draw_ranges(axes: Axes, thing: Thing) -> None:
    """The ranges of the origin, where the program gives any."""
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    if not np.isfinite([xa, xb, ya, yb]).any():
        return
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    low, high = (max(xa, x0), max(ya, y0)), (min(xb, x1), min(yb, y1))
    if low[0] <= high[0] and low[1] <= high[1]:
        area(axes, shapely.box(*low, *high), order=2.5, facecolor="none", edgecolor=FREE, linestyle="--", linewidth=1.0)


def _index(relation: SceneRelation) -> object:
    return relation.path[-1] if relation.path else None
