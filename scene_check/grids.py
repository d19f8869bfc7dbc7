"""Grids: the members keep their places in a common frame, whose pose is within its ranges (metres and radians)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from geom.planar import turned
from scene_check.measures import to_place
from scene_check.model import TOLERANCE_M, TURN, CheckObject, PosedGrid, Violation


def disordered_grids(grids: Sequence[PosedGrid], by_name: Mapping[str, CheckObject]) -> Iterator[Violation]:
    """Violations of grids: how far a member is from its cell, or turned from the first, or the grid from its ranges."""
    for grid in grids:
        members = [by_name[name] for name in grid.members]
        yaw = members[0].yaw_rad
        cells = turned(grid.offsets_m, yaw)
        middle = members[0].origin_m[:2] - cells[0]
        for member, cell in zip(members, cells, strict=True):
            off = float(np.hypot(*(member.origin_m[:2] - middle - cell)))
            twist = abs((member.yaw_rad - yaw + 0.5 * TURN) % TURN - 0.5 * TURN)
            if off > 2.0 * TOLERANCE_M:
                yield Violation("grid", (member.name, members[0].name), off, 0.0, "m", grid.name)
            if twist > TOLERANCE_M:
                yield Violation("grid", (member.name, members[0].name), float(twist), 0.0, "rad", grid.name)
        x, y = to_place(middle[None], grid.place)[0]
        for axis, value, (low, high) in (("x", x, grid.domain.x_m), ("y", y, grid.domain.y_m)):
            if not low - 2.0 * TOLERANCE_M <= value <= high + 2.0 * TOLERANCE_M:
                yield Violation("range", (grid.name,), float(value), low if value < low else high, "m", axis)
        low, high = grid.domain.yaw_rad
        past = (yaw - grid.place.yaw_rad - low) % TURN
        if min(past - (high - low), TURN - past) > TOLERANCE_M:
            yield Violation("range", (grid.name,), float(yaw - grid.place.yaw_rad), low, "rad", "yaw")
