"""Stacked contents of a receptacle: which thing touches which, and whether the stack is stable for any masses.

For each thing only three facts count: the hull of its contact from below (its support), its middle, and the areas where
things on it press. A thing on one other transmits a force within the hull of its middle and of the pressures on it; one
on several may press anywhere on its contacts. Where the middle and all pressures lie in the support of each thing,
forces balance for any masses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil, inf
from typing import NamedTuple

import shapely
from shapely.geometry.base import BaseGeometry

from scenec.solve.model import SolverModel
from scenec.solve.placed import Placed, bounds_gap
from scenec.solve.planar import SLACK_M
from scenec.solve.resting import CONTACT_M, GRAIN_M


class StackLevel(NamedTuple):
    """Tops of contents at one height over the floor of their place: hull of all in P, and the middle of each."""

    base_m: float
    hull: BaseGeometry
    middles: tuple[shapely.Point, ...]


def stands_on_contents(model: SolverModel, placed: Placed) -> bool:
    """Whether other contents must support it: off the floor of a volume, and without fixed poses."""
    thing = model.things[placed.name]
    return thing.place.is_volume and placed.placement.base_m > SLACK_M and not thing.domain.fixed_poses


def unsupported(model: SolverModel, assignment: Mapping[str, Placed], parent: str, place: str) -> set[str]:
    """Names of contents of a place that are not supported or would tip under load; empty without a stack."""
    contents = {p.name: p for p in assignment.values() if p.parent == parent and p.place == place}
    if not any(stands_on_contents(model, placed) for placed in contents.values()):
        return set()
    touched = {name: _supports(model, name, contents) for name in contents}
    pressed: dict[str, list[BaseGeometry]] = {name: [] for name in contents}
    wrong: set[str] = set()
    for name in sorted(contents, key=lambda n: (-contents[n].contact.low_m, n)):  # from the top down
        contact = contents[name].contact
        if not stands_on_contents(model, contents[name]):
            support = contact.foot.convex_hull
            held = not pressed[name] or support.covers(contact.middle)
        else:
            support = shapely.union_all(list(touched[name].values())).convex_hull
            held = support.buffer(-contact.stability_margin_m).covers(contact.middle)
        if not held or not all(support.buffer(SLACK_M).covers(load) for load in pressed[name]):
            wrong.add(name)
            continue
        for below, area in touched[name].items():
            pressed[below] += [area] if len(touched[name]) > 1 else [contact.middle, *pressed[name]]
    return wrong


def _supports(model: SolverModel, name: str, contents: Mapping[str, Placed]) -> dict[str, BaseGeometry]:
    # Contact areas with other contents below it, by name.
    placed = contents[name]
    if not stands_on_contents(model, placed):
        return {}
    low_m, foot = placed.contact.low_m, placed.contact.foot
    areas = {
        other.name: other.contact.top_at(low_m).intersection(foot)
        for other in contents.values()
        if other is not placed and other.name not in model.carriers
        if abs(other.contact.high_m - low_m) <= CONTACT_M and bounds_gap(placed, other) < 0.0
    }
    return {other: area for other, area in areas.items() if not area.is_empty}


def stack_levels(model: SolverModel, assignment: Mapping[str, Placed], name: str) -> list[StackLevel]:
    """Heights at which contents of its volume may support a thing, lowest first. Contents that are owners of other
    things support nothing."""
    thing = model.things[name]
    if not thing.place.is_volume or thing.domain.fixed_poses:
        return []
    floor = float(thing.place.origin_P_m[2])
    mates = [
        placed.contact
        for placed in assignment.values()
        if placed.parent == thing.parent and placed.place == thing.place.name and placed.name not in model.carriers
        if placed.name != name
    ]
    levels: list[StackLevel] = []
    last = -inf
    for high in sorted({mate.high_m for mate in mates}):
        if high - last <= CONTACT_M and levels:
            levels.pop()  # the higher of two that are level
        last = high
        tops = [area.convex_hull for mate in mates if not (area := mate.top_at(high)).is_empty]
        hull = shapely.union_all(tops).convex_hull
        base = ceil((high - floor) / GRAIN_M - 1e-3) * GRAIN_M
        levels.append(StackLevel(base, hull, tuple(top.centroid for top in tops)))
    return levels


def stacked(model: SolverModel, assignment: Mapping[str, Placed]) -> set[str]:
    """Names of all things that stand on other contents."""
    return {name for name, placed in assignment.items() if stands_on_contents(model, placed)}


def without(model: SolverModel, assignment: Mapping[str, Placed], names: Iterable[str]) -> dict[str, Placed]:
    """The assignment less `names` and all stacked things that lose their support."""
    gone = set(names)
    left = {name: placed for name, placed in assignment.items() if name not in gone}
    while places := {(left[name].parent, left[name].place) for name in stacked(model, left)}:
        down = {name for parent, place in places for name in unsupported(model, left, parent, place)}
        down &= stacked(model, left)
        if not down:
            break
        left = {name: placed for name, placed in left.items() if name not in down}
    return left
