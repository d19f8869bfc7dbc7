"""Small problems built by hand: boxes on a table, with relations, ranges, keep-outs."""

from __future__ import annotations

import numpy as np
from shapely import Polygon, box

from scenec.ir.problem import Body, Problem, Thing
from schemas.scene.geometry import BACKGROUND, Domain, Prism, ScenePlace, SceneRelation, Stance

ANY = (-np.inf, np.inf)


def outline(width: float, depth: float) -> np.ndarray:
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * [width, depth]


def box_body(name: str, width: float, depth: float, height: float = 0.05, holds: bool = False) -> Body:
    """A box; with `holds`, its top is a surface."""
    stance = Stance((1.0, 0.0, 0.0, 0.0), (Prism(outline(width, depth), 0.0, height),), 0.0)
    top = ScenePlace("top", Polygon(outline(width, depth)), np.array([0.0, 0.0, height]))
    return Body(name, (stance,), (top,) if holds else ())


def table(width: float, depth: float, clearance: float = np.inf) -> ScenePlace:
    return ScenePlace("tabletop", box(-width / 2, -depth / 2, width / 2, depth / 2), np.zeros(3), clearance)


def thing(
    name: str,
    size: tuple[float, float] | Body,
    place: ScenePlace,
    *,
    x=ANY,
    y=ANY,
    yaw=(0.0, 0.0),
    parent: str = BACKGROUND,
    height: float = 0.05,
    fixed_poses=(),
) -> Thing:
    body = size if isinstance(size, Body) else box_body(name, *size, height)
    path = ("layout", "nodes", name)
    return Thing(name, body, parent, place, Domain(x, y, yaw, (0,), fixed_poses, (*path, "placement", "ranges")), path)


def left_of(number: int, one: str, two: str, gap: float = 0.0) -> SceneRelation:
    return SceneRelation("before", (one, two), (1.0, 0.0), gap, path=("relations", number), word="left_of")


def problem(things, relations=(), clearance: float = 0.01, **rules) -> Problem:
    return Problem("test", None, np.eye(4), tuple(things), tuple(relations), clearance, **rules)
