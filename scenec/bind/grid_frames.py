"""The frame of a grid: a thing as large as all members together, on which each member has a fixed pose.

The frame is placed like any thing, within the ranges of the grid, so that the members keep their pitch wherever it is.
It holds the pieces of all members, with their heights: what is clear of the frame is clear of each of them. Metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from scenec.bind.primitives import UPRIGHT
from scenec.bind.written_poses import domain_at, yaw_range_of
from scenec.ir.problem import Body, Thing
from schemas.scene.geometry import Domain, FixedPose, Prism, ScenePlace, Stance
from schemas.scene.placing import GridGroup
from source.tree import Path

GRID = "grid"  # name of the place of the members, and asset of the frame


def with_frame(name: str, group: GridGroup, members: Sequence[Thing], path: Path) -> tuple[Thing, ...]:
    """The frame of a grid, then its members on it. `members` are those of all cells, in the order of the cells, on the
    surface of the grid."""
    rows, columns = len(group.row_names), len(group.column_names)
    middles = [
        ((c - 0.5 * (columns - 1)) * group.pitch[0], (r - 0.5 * (rows - 1)) * group.pitch[1]) for r, c in group.cells()
    ]
    prisms = tuple(
        Prism(prism.outline_m + np.array(middle), prism.low_m, prism.high_m)
        for member, middle in zip(members, middles, strict=True)
        for prism in member.body.resting_orientations[0].prisms
    )
    hull = shapely.MultiPoint(np.concatenate([prism.outline_m for prism in prisms])).convex_hull
    assert isinstance(hull, shapely.Polygon), "a footprint has an area"
    body = Body(GRID, (Stance(UPRIGHT, prisms, 0.0),))
    everywhere = (-np.inf, np.inf)
    x, y = group.ranges.x or everywhere, group.ranges.y or everywhere
    domain = Domain(x, y, yaw_range_of(group.ranges), (0,), (), (*path, "ranges"))
    frame = Thing(name, body, members[0].parent, members[0].place, domain, path, name, (), True)
    place = ScenePlace(GRID, hull, np.zeros(3))
    on_frame = (
        replace(member, parent=name, place=place, domain=_at(member, *middle, path))
        for member, middle in zip(members, middles, strict=True)
    )
    return (frame, *on_frame)


def _at(member: Thing, x_m: float, y_m: float, path: Path) -> Domain:
    at = (*path, "pitch")
    z_m = member.body.resting_orientations[0].origin_height_m
    return domain_at((FixedPose(x_m, y_m, z_m, 0.0, "", at),), at)
