"""Spaces that joints sweep, for proofs: where they are certain for a thing, whatever pose others take.

That is so for what stands on the owner of the space, and beside an owner that has one pose only.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from geom.convex_outlines import with_fewer_corners
from scenec.ir.problem import Problem, Thing
from source.tree import Path

FEWER_CORNERS_M = 1e-3  # by which spaces are smaller here, for the sake of speed


class CertainSpace(NamedTuple):
    """An upright prism in A of a thing's place that the thing must not enter; heights over the place."""

    area: BaseGeometry
    low_m: float
    high_m: float
    path: Path
    title: str


def certain_spaces(problem: Problem, thing: Thing) -> tuple[CertainSpace, ...]:
    """The spaces kept clear of a thing, as far as they are certain."""
    return tuple(_spaces(problem, thing)) if problem.keep_clear else ()


def beside(spaces: tuple[CertainSpace, ...]) -> str:
    """What the text of a proof says of them, empty without any."""
    titles = list(dict.fromkeys(space.title for space in spaces))
    return f", beside {' and '.join(titles)}" if titles else ""


def _spaces(problem: Problem, thing: Thing) -> Iterator[CertainSpace]:
    owners = {other.name: other for other in problem.things if other.parent == thing.parent and other is not thing}
    x, y, z = (float(v) for v in thing.place.origin_P_m)
    for space in problem.keep_clear:
        pose = None
        if space.owner == thing.parent and thing.place.link not in space.links:
            pose = (0.0, 0.0, 0.0, 0.0)
        elif space.owner in owners:
            pose = _only_pose(owners[space.owner])
        if pose is None:
            continue
        at_x, at_y, at_z, yaw = pose
        c, s = float(np.cos(yaw)), float(np.sin(yaw))
        for layer in space.layers:
            inside = with_fewer_corners(layer.polygon, -FEWER_CORNERS_M)
            if not inside.is_empty:
                area = affine_transform(inside, [c, -s, s, c, at_x - x, at_y - y])
                yield CertainSpace(area, layer.low_m + at_z - z, layer.high_m + at_z - z, space.path, space.title)


def _only_pose(owner: Thing) -> tuple[float, float, float, float] | None:
    """(x, y, z, yaw) in P of the asset frame of a thing that has one pose only; None for any other."""
    domain, origin = owner.domain, owner.place.origin_P_m
    if len(domain.fixed_poses) == 1:
        (at,) = domain.fixed_poses
        x, y, z, yaw = at.x_m, at.y_m, at.z_m, at.yaw_rad
    elif domain.fixed_poses or owner.place.is_volume or len(domain.orientation_indices) != 1:
        return None
    else:
        spans = (domain.x_m, domain.y_m, domain.yaw_rad)
        if any(low != high for low, high in spans):
            return None
        (x, _), (y, _), (yaw, _) = spans
        z = owner.body.resting_orientations[domain.orientation_indices[0]].origin_height_m
    return x + float(origin[0]), y + float(origin[1]), z + float(origin[2]), yaw
