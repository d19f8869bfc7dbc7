"""Draws a compiled scene from above: supports, footprints with names and fronts, relations, clearance."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import shapely
from matplotlib.axes import Axes
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from geom.pose import matrix_of
from render.figure import png
from scenec.emit.scene import world_frames
from scenec.ir.problem import Placement, Problem, Thing
from scenec.pictures.canvas import CLEAR, EDGE, FREE, INK, SUPPORT, THINGS, WRONG, area, name, sheet
from scenec.pictures.relations import draw_relations
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, Prism, ScenePlace, Stance

_MOST_NAMES = 24


def plan(problem: Problem, placements: Mapping[str, Placement], title: str = "") -> bytes:
    """PNG of the scene from above. Owners are drawn before what they carry, low things before high ones."""
    frames = world_frames(problem, placements)
    shapes = {
        t.name: footprint(t.body.resting_orientations[placements[t.name].stance], frames[t.name])
        for t in problem.things
    }
    supports = world_supports(problem, frames)
    everything = shapely.union_all([*supports, *shapes.values()])
    bounds = np.array(everything.bounds if not everything.is_empty else (0.0, 0.0, 1.0, 1.0))
    picture, axes = sheet(bounds[:2], bounds[2:], title or problem.scene)
    draw_supports(axes, problem, frames)
    order = sorted(problem.things, key=lambda t: (_depth(t, problem), _top(t, placements, frames), t.name))
    colours = {thing.name: THINGS[index % len(THINGS)] for index, thing in enumerate(problem.things)}
    for level, thing in enumerate(order):
        _draw_thing(axes, thing, shapes[thing.name], frames[thing.name], placements, colours[thing.name], 2.0 + level)
    above = 3.0 + len(order)
    _draw_clearance(axes, problem, shapes, above)
    if len(order) <= _MOST_NAMES:
        for thing in order:
            name(axes, _label_at(thing, shapes, problem), thing.name, order=above + 2.0)
    middles = {item: np.array(shape.centroid.coords[0]) for item, shape in shapes.items()}
    draw_relations(axes, problem.relations, middles, lambda _: INK, order=above + 1.0)
    return png(picture)


def footprint(stance: Stance, X_WU: FloatArray) -> BaseGeometry:
    """The union of the outlines of a stance, seen from above in the world."""
    return shapely.union_all([_turned(shapely.Polygon(prism.outline_m), X_WU) for prism in stance.prisms])


def place_outline(place: ScenePlace, X_WU: FloatArray) -> BaseGeometry:
    """The polygon of a surface, or the floor of a volume, seen from above; `X_WU` is the frame of its owner."""
    moved = np.array(X_WU)
    moved[:3, 3] = (X_WU @ np.append(np.asarray(place.origin_P_m, dtype=np.float64), 1.0))[:3]
    return _turned(place.floor, moved)


def world_supports(problem: Problem, frames: Mapping[str, FloatArray]) -> list[BaseGeometry]:
    """Outlines in the world of the places of the background in use, and of the background itself."""
    used = {t.place.name: t.place for t in problem.things if t.parent == BACKGROUND}
    shapes = [place_outline(place, frames[BACKGROUND]) for place in used.values()]
    if problem.background is not None:
        shapes.append(footprint(problem.background.resting_orientations[0], frames[BACKGROUND]))
    return shapes


def draw_supports(axes: Axes, problem: Problem, frames: Mapping[str, FloatArray]) -> None:
    """The background, its places in use, keep-outs, spaces kept clear and the reach of the robot."""
    if problem.background is not None:
        whole = footprint(problem.background.resting_orientations[0], frames[BACKGROUND])
        area(axes, whole, order=0.5, facecolor="#f7f5f1", edgecolor=EDGE, linewidth=0.8)
    for place in {t.place.name: t.place for t in problem.things if t.parent == BACKGROUND}.values():
        outline = place_outline(place, frames[BACKGROUND])
        area(axes, outline, order=1.0, facecolor=SUPPORT, edgecolor=EDGE, linewidth=1.2)
    for rule in problem.keep_outs:
        if rule.parent in frames:
            moved = np.array(frames[rule.parent])
            moved[:3, 3] = (moved @ np.append(np.asarray(rule.place.origin_P_m, dtype=np.float64), 1.0))[:3]
            area(
                axes, _turned(rule.polygon, moved), order=1.5, facecolor="none", edgecolor=WRONG, hatch="///", alpha=0.5
            )
    for space in problem.keep_clear:
        if space.owner in frames:
            swept = shapely.union_all([_turned(layer.polygon, frames[space.owner]) for layer in space.layers])
            area(axes, swept, order=1.5, facecolor="none", edgecolor=WRONG, hatch="...", alpha=0.5)
    if problem.reach is not None:
        base = shapely.Point(problem.reach.base_m[:2])
        ring = base.buffer(problem.reach.most_m, 64).difference(base.buffer(problem.reach.least_m, 64))
        area(axes, ring, order=1.6, facecolor="none", edgecolor=FREE, linestyle="--", linewidth=1.0)


def _draw_thing(
    axes: Axes,
    thing: Thing,
    shape: BaseGeometry,
    X_WU: FloatArray,
    placements: Mapping[str, Placement],
    colour: str,
    order: float,
) -> None:
    area(axes, shape, order=order, facecolor=colour, edgecolor=INK, linewidth=0.9, alpha=0.92)
    stance = thing.body.resting_orientations[placements[thing.name].stance]
    front = (X_WU[:3, :3] @ matrix_of(np.array(stance.quat_wxyz)))[:2, 0]
    if np.linalg.norm(front) > 0.5:  # A front that points up or down shows nothing from above.
        start = X_WU[:2, 3]
        length = 0.35 * np.sqrt(shape.area)
        axes.plot(*np.column_stack([start, start + length * front]), color=INK, linewidth=1.4, zorder=order + 0.2)
        axes.plot(*start, marker="o", markersize=2.5, color=INK, zorder=order + 0.2)


def _draw_clearance(axes: Axes, problem: Problem, shapes: Mapping[str, BaseGeometry], order: float) -> None:
    """Each footprint grown by half the clearance: these do not overlap among things that share a place."""
    if problem.clearance_m <= 0.0:
        return
    for shape in shapes.values():
        grown = shape.buffer(problem.clearance_m / 2.0)
        area(axes, grown, order=order, facecolor="none", edgecolor=CLEAR, linestyle=":", linewidth=0.8)


def _label_at(thing: Thing, shapes: Mapping[str, BaseGeometry], problem: Problem) -> FloatArray:
    """A point of the footprint that no child covers, where there is one."""
    children = [shapes[t.name] for t in problem.things if t.parent == thing.name]
    own = shapes[thing.name]
    free = own.difference(shapely.union_all(children)) if children else own
    point = free.centroid if free.contains(free.centroid) else free.representative_point()
    if free.is_empty:
        point = own.centroid
    return np.array(point.coords[0])


def _depth(thing: Thing, problem: Problem) -> int:
    """Number of movable owners below it."""
    owners = {t.name: t.parent for t in problem.things}
    depth, name_ = 0, thing.parent
    while name_ in owners:
        depth, name_ = depth + 1, owners[name_]
    return depth


def _top(thing: Thing, placements: Mapping[str, Placement], frames: Mapping[str, FloatArray]) -> float:
    stance = thing.body.resting_orientations[placements[thing.name].stance]
    return float(frames[thing.name][2, 3]) - stance.origin_height_m + max(_highs(stance.prisms))


def _highs(prisms: tuple[Prism, ...]) -> list[float]:
    return [prism.high_m for prism in prisms]


def _turned(shape: BaseGeometry, X_WU: FloatArray) -> BaseGeometry:
    (a, b), (c, d) = X_WU[:2, :2]
    return affine_transform(shape, [a, b, c, d, X_WU[0, 3], X_WU[1, 3]])
