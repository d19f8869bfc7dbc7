"""Contents of a receptacle that stand on other contents: what touches what, and whether it stays whatever things weigh.

Of a pile only three facts count, for each thing: the hull of where it is touched from below (its support), its middle,
and where what stands on it presses. A thing that stands on one other hands down a force that lies in the hull of its
middle and of what presses on it; one on several may press anywhere that it touches. Where middle and pressures lie in
the support of each thing, the forces balance for any weights.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil, inf
from typing import NamedTuple

import shapely
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Volume
from scenec.solve.model import SLACK_M, Model
from scenec.solve.placed import Placed, bounds_gap
from scenec.solve.resting import CONTACT_M, GRAIN_M


class Level(NamedTuple):
    """Tops of contents at one height over the floor: the hull of all in P, and the middle of each."""

    base_m: float
    hull: BaseGeometry
    middles: tuple[shapely.Point, ...]


def stands_on_contents(model: Model, placed: Placed) -> bool:
    """Whether other contents must hold it: off the floor of a volume, at no pose that was written."""
    thing = model.things[placed.name]
    return isinstance(thing.place, Volume) and placed.placement.base_m > SLACK_M and not thing.domain.spots


def fallen(model: Model, assignment: Mapping[str, Placed], parent: str, place: str) -> set[str]:
    """Names of contents of a place that are not held, or that what stands on them would tip; empty without a pile."""
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


def _supports(model: Model, name: str, contents: Mapping[str, Placed]) -> dict[str, BaseGeometry]:
    # Where each other content touches it from below.
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


def levels(model: Model, assignment: Mapping[str, Placed], name: str) -> list[Level]:
    """Heights on which contents of its volume may carry a thing, lowest first. Nothing stands on what carries something
    of its own."""
    thing = model.things[name]
    if not isinstance(thing.place, Volume) or thing.domain.spots:
        return []
    floor = float(thing.place.origin_P_m[2])
    mates = [
        placed.contact
        for placed in assignment.values()
        if placed.parent == thing.parent and placed.place == thing.place.name and placed.name not in model.carriers
        if placed.name != name
    ]
    found: list[Level] = []
    last = -inf
    for high in sorted({mate.high_m for mate in mates}):
        if high - last <= CONTACT_M and found:
            found.pop()  # the higher of two that are level
        last = high
        tops = [area.convex_hull for mate in mates if not (area := mate.top_at(high)).is_empty]
        hull = shapely.union_all(tops).convex_hull
        base = ceil((high - floor) / GRAIN_M - 1e-3) * GRAIN_M
        found.append(Level(base, hull, tuple(top.centroid for top in tops)))
    return found


def piled(model: Model, assignment: Mapping[str, Placed]) -> set[str]:
    """Names of all that stands on contents."""
    return {name for name, placed in assignment.items() if stands_on_contents(model, placed)}


def without(model: Model, assignment: Mapping[str, Placed], names: Iterable[str]) -> dict[str, Placed]:
    """The assignment less `names` and all that falls without them."""
    gone = set(names)
    left = {name: placed for name, placed in assignment.items() if name not in gone}
    while places := {(left[name].parent, left[name].place) for name in piled(model, left)}:
        down = {name for parent, place in places for name in fallen(model, left, parent, place)}
        down &= piled(model, left)
        if not down:
            break
        left = {name: placed for name, placed in left.items() if name not in down}
    return left
