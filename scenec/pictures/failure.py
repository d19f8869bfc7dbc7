"""Why there is no scene, seen from above: the place, where each thing in question may be, what conflicts."""

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
from scenec.ir.problem import Exhausted, FloatArray, Infeasible, Path, Problem, RelationIR, Result, Surface, Thing
from scenec.pictures.blockers import footprint, owner_parts, seen_from_above, standing
from scenec.pictures.canvas import CLEAR, EDGE, FREE, INK, SUPPORT, THINGS, WRONG, area, name, sheet
from scenec.pictures.relations import draw_relations
from scenec.solve.check import Assignment
from scenec.solve.model import Model, model_of
from scenec.solve.regions import alone, feasible
from scenec.source.tree import written

_CAPTION = 105  # characters a line
_MOST_LINES = 9
_TILT_RAD = 0.6  # apart in x and y: ranges may leave one of them
_MOST_WAITING = 6  # things without a place that are drawn


def failure(problem: Problem, result: Result, paths: Sequence[Path] = (), chosen: str = "") -> bytes:
    """PNG of the place where the conflict is, in the frame of its anchor; `paths` are the conflicting constraints, and
    `chosen` says of which combination.

    Green is where the origin of a thing may be as far as it alone is concerned (place, ranges, keep-outs); dashed
    outlines are its footprint, red what cannot hold together. Things are drawn apart where nothing ties them to a spot.
    Grey is what is in the way whatever the others do: parts of the owner, things with one pose. After a search without
    an answer it is all that stood at best, and green is what that leaves.
    """
    names = _involved(problem, result, paths)
    stood = result.stood if isinstance(result, Exhausted) else {}
    stood = {name: at for name, at in stood.items() if name != _failing(result)}
    things = [thing for thing in problem.things if thing.name in names and thing.name not in stood]
    (parent, anchor), _ = Counter((t.parent, t.place.name) for t in things or problem.things).most_common(1)[0]
    here = [t for t in things or problem.things if (t.parent, t.place.name) == (parent, anchor)]
    place = here[0].place
    outline = place.polygon if isinstance(place, Surface) else place.opening
    bounds = np.array(outline.bounds)
    caption = _caption(problem, result, paths)
    made, axes = sheet(bounds[:2], bounds[2:], _title(problem, result, chosen), len(caption))
    area(axes, outline, order=1.0, facecolor=SUPPORT, edgecolor=EDGE, linewidth=1.2)
    for rule in problem.keep_outs:
        if (rule.parent, rule.place.name) == (parent, anchor):
            area(axes, rule.polygon, order=1.5, facecolor="none", edgecolor=WRONG, hatch="///", alpha=0.5)
    for part in owner_parts(problem, parent, anchor):
        area(axes, part, order=1.6, facecolor=CLEAR, edgecolor=INK, hatch="xxx", linewidth=0.6, alpha=0.5)
    model = model_of(problem)
    placed = {name: model.put(name, at) for name, at in stood.items()}
    ghosts = _ghosts(model, here, outline, placed)
    blocked = [(t, at) for t, at in standing(problem, result, parent, anchor) if t.name not in ghosts]
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
    made.supxlabel("\n".join(caption), x=0.02, ha="left", fontsize=8, color=INK)
    return png(made)


def _involved(problem: Problem, result: Result, paths: Sequence[Path]) -> set[str]:
    """Names of the things that the conflicting constraints speak of; after a search without an answer those related to
    the one that kept failing, and some that never had a place."""
    found = set[str]()
    if isinstance(result, Exhausted):
        found = {result.blocking}.union(*(r.things for r in problem.relations if result.blocking in r.things))
        waiting = [thing.name for thing in problem.things if thing.name not in result.stood]
        found |= set(waiting[:_MOST_WAITING])
    for path in paths:
        for relation in problem.relations:
            if relation.path and path[: len(relation.path)] == relation.path:
                found |= set(relation.things)
        for thing in problem.things:
            if (thing.path and path[: len(thing.path)] == thing.path) or (
                thing.group is not None and path[:3] == ("layout", "groups", thing.group)
            ):
                found.add(thing.name)
    return found


def _title(problem: Problem, result: Result, chosen: str) -> str:
    among = f"\nwith {chosen}" if chosen else ""
    if isinstance(result, Exhausted):
        if result.note:
            return f"{problem.scene}: not found{among}"
        return f"{problem.scene}: not found in {result.steps} steps; {result.blocking} failed most{among}"
    return f"{problem.scene}: there is no such scene{among}"


def _caption(problem: Problem, result: Result, paths: Sequence[Path]) -> list[str]:
    said = []
    if isinstance(result, Infeasible):
        said = textwrap.wrap(result.proof.text, _CAPTION)
    elif isinstance(result, Exhausted) and result.note:
        said = textwrap.wrap(result.note, _CAPTION)
    elif isinstance(result, Exhausted):
        said = [f"{result.placed} of {result.of} things could be placed at best (grey); green is what they leave"]
    words = {relation.path: relation for relation in problem.relations}
    for path in paths:
        relation = words.get(path)
        what = f": {' '.join([relation.word or relation.kind, *relation.as_written])}" if relation else ""
        said.append(f"- {written(path)}{what}")
    return said if len(said) <= _MOST_LINES else [*said[:_MOST_LINES], f"... and {len(said) - _MOST_LINES} more"]


def _failing(result: Result) -> str | None:
    return result.blocking if isinstance(result, Exhausted) else None


def _ghosts(
    model: Model, things: Sequence[Thing], outline: BaseGeometry, placed: Assignment
) -> dict[str, tuple[FloatArray, BaseGeometry]]:
    """By name: where to draw the footprint, in A, and the free region of its origin, in A."""
    x0, y0, x1, y1 = outline.bounds
    centre, radius = np.array([x0 + x1, y0 + y1]) / 2.0, 0.3 * np.array([x1 - x0, y1 - y0])
    found: dict[str, tuple[FloatArray, BaseGeometry]] = {}
    for index, thing in enumerate(things):
        region = _free(model, thing, placed)
        angle = 2.0 * np.pi * index / max(len(things), 1) + np.pi + _TILT_RAD
        apart = centre + radius * np.array([np.cos(angle), np.sin(angle)]) * (len(things) > 1)
        wanted = _within(thing, apart)
        if not region.is_empty:
            near = shapely.shortest_line(region, shapely.Point(wanted))
            wanted = np.array(near.coords[0])
        found[thing.name] = wanted, region
    return found


def _within(thing: Thing, wanted: FloatArray) -> FloatArray:
    """The point of the thing's ranges nearest to the wanted one."""
    low = np.array([thing.domain.x_m[0], thing.domain.y_m[0]])
    high = np.array([thing.domain.x_m[1], thing.domain.y_m[1]])
    if thing.domain.spots:
        spots = np.array([[spot.x_m, spot.y_m] for spot in thing.domain.spots])
        return spots[np.argmin(np.linalg.norm(spots - wanted, axis=1))]
    return np.clip(wanted, low, high)


def _yaw_rad(thing: Thing) -> float:
    """The allowed heading nearest to none."""
    if thing.domain.spots:
        return thing.domain.spots[0].yaw_rad
    return float(np.clip(0.0, *thing.domain.yaw_rad))


def _free(model: Model, thing: Thing, placed: Assignment) -> BaseGeometry:
    """Where the origin may be in A, at the drawn heading, as far as itself and what is placed are concerned."""
    if thing.domain.spots:
        return shapely.MultiPoint([(spot.x_m, spot.y_m) for spot in thing.domain.spots])
    turned = model.shapes[thing.name][thing.domain.stances[0]].turned(_yaw_rad(thing))
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    return translate(feasible(model, thing.name, turned, placed, alone(model, thing.name, turned))[0], -ox, -oy)


def _draw(axes: Axes, model: Model, thing: Thing, ghost: tuple[FloatArray, BaseGeometry], colour: str) -> None:
    at, region = ghost
    area(axes, region, order=2.0, facecolor=FREE, edgecolor=FREE, alpha=0.13, linewidth=0.8)
    wrong = region.is_empty
    shape = seen_from_above(thing, thing.domain.stances[0], _yaw_rad(thing), at)
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


def _index(relation: RelationIR) -> object:
    return relation.path[-1] if relation.path else None
