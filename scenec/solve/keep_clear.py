"""Spaces that joints sweep, for the solver: what stands on their owner, and pairs of other things as rules.

A space is fixed in the frame of its owner, so that for things on the owner it is a keep-out of their place. All other
things are on something that stands beside the owner or beside what carries it, and stay in the shape of that (things
that carry others include the space above their places): one rule for each of these is enough.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from weakref import WeakKeyDictionary

import shapely
from shapely import Polygon
from shapely.affinity import translate

from geom.convex_outlines import few_convex_outlines, with_fewer_corners
from scenec.ir.problem import Problem, Thing
from scenec.solve.planar import polygon as polygon_of
from schemas.scene.geometry import BACKGROUND, KeepClear, PlaceLayer, ScenePlace, SceneRelation

KIND = "keep_clear"
FEWER_CORNERS_M = 1e-3  # half of what spaces are larger by here, for the sake of speed
JOINED_SHARE = 2e-3  # of the area of a space that joining two of its convex parts may add
REACH_M = 1e-3  # beyond a place: more than any slack by which footprints may pass its border


def keep_outs_of(problem: Problem, parent: str, place: ScenePlace) -> tuple[tuple[Polygon, float, float], ...]:
    """(polygon, low, high) in P of the spaces of `parent` that things on one of its places must leave free; those of a
    link that carries the place move with it, and are no obstacle.

    What stands on a place stays on its polygon, so that only that part of a space counts, unless poses in the air are
    written, or things carry others, which may hang over.
    """
    layers = [
        layer
        for space in problem.keep_clear
        if space.owner == parent and place.link not in space.links
        for layer in coarse(space).layers
    ]
    placed = [thing for thing in problem.things if thing.parent == parent and thing.place.name == place.name]
    carriers = {thing.parent for thing in problem.things}
    if not layers or any(thing.domain.fixed_poses or thing.name in carriers for thing in placed):
        return tuple((layer.polygon, layer.low_m, layer.high_m) for layer in layers)
    x, y = (float(v) for v in place.origin_P_m[:2])
    areas = [layer.polygon for layer in place.layers] or [place.polygon]
    within = translate(shapely.union_all(areas), x, y).buffer(REACH_M, join_style="mitre")
    parts = [(part, layer) for layer in layers for part in shapely.get_parts(layer.polygon.intersection(within))]
    return tuple(
        (part, layer.low_m, layer.high_m) for part, layer in parts if isinstance(part, Polygon) and part.area > 0.0
    )


def keep_clear_rules(problem: Problem, things: dict[str, Thing]) -> Iterator[SceneRelation]:
    """A rule for each space and each thing beside its owner, or beside what carries that."""
    for space in problem.keep_clear:
        zone = coarse(space)
        for other in beside(space, things):
            yield SceneRelation(KIND, (space.owner, other), path=space.path, word=KIND, zone=zone)


_COARSE: WeakKeyDictionary[KeepClear, KeepClear] = WeakKeyDictionary()


def coarse(space: KeepClear) -> KeepClear:
    """The space a little larger, as few convex prisms with few corners; made once."""
    known = _COARSE.get(space)
    if known is None:
        layers = tuple(
            PlaceLayer(low, high, polygon_of(outline))
            for low, high, polygon in space.layers
            for outline in few_convex_outlines(with_fewer_corners(polygon, FEWER_CORNERS_M), JOINED_SHARE)
        )
        known = _COARSE[space] = replace(space, layers=layers)
    return known


def beside(space: KeepClear, things: dict[str, Thing]) -> tuple[str, ...]:
    """Names of the things beside the owner of a space, or beside a thing that carries it; none of the background's."""
    names: list[str] = []
    name = space.owner
    while name != BACKGROUND:
        parent = things[name].parent
        names += [other for other, thing in things.items() if thing.parent == parent and other != name]
        name = parent
    return tuple(names)
