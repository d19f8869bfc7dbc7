"""`on`: an object stands or lies on a surface of another."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.polygons import in_polygon
from task.predicates.grip.grip import bodies_of
from task.predicates.placement.placed import LEAST_TIP_COSINE, Placed
from task.predicates.protocol import Metres, Object, Share

SUNK_M = 0.005  # how far contacts of simulators sink in
RINGS = (0.354, 0.612, 0.791, 0.935)  # of the base, around the middles of four parts of equal area
LOWEST_M = 0.005  # corners within so much of the lowest one are what an object stands on


class On(Placed):
    """The lowest point is at the height of the surface, the centre over its polygon, and most of the object's base too.

    Where contacts were observed the two must touch, so that a thing that hovers is not on it.
    """

    func: ClassVar[str] = "on"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts", "surfaces"})
    object: Object
    support: Object
    surface: str = Field(default="auto", description="an anchor of the record; the main surface by default")
    gap_m: Metres = Field(
        default=0.01, description="most height of the lowest point over the surface; public suites allow 0.02 m"
    )
    overlap: Share = Field(
        default=0.5, description="least share of the base over the surface, as public suites have it"
    )
    touching: bool = Field(default=True, description="whether they must touch where contacts were observed")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        surface, body = frames.surface(self.support, self.surface)
        corners = frames.in_anchor(frames.points(self.object), surface, body)
        centre = frames.in_anchor(frames.centre(self.object)[:, None], surface, body)[:, 0]
        height = corners[..., 2]
        lowest = height.min(axis=1)
        there = (lowest <= self.gap_m) & (lowest >= -SUNK_M) & in_polygon(centre[:, 0], centre[:, 1], surface.polygon)
        there &= frames.rotation(body)[:, 2, 2] >= LEAST_TIP_COSINE
        if not there.any():
            return there
        base = height <= lowest[:, None] + LOWEST_M
        weight = base.astype(np.float64) / base.sum(axis=1)[:, None]
        middle = [(corners[..., k] * weight).sum(axis=1)[:, None] for k in (0, 1)]
        over = np.zeros(len(frames))
        for ring in RINGS:
            x, y = (middle[k] + (corners[..., k] - middle[k]) * ring for k in (0, 1))
            over += (base & in_polygon(x, y, surface.polygon)).sum(axis=1)
        there &= over >= self.overlap * len(RINGS) * base.sum(axis=1)
        if self.touching and frames.log.touching is not None:
            touch = np.zeros(len(frames), dtype=bool)
            for one in bodies_of(frames, self.object):
                touch |= frames.touches_any(one, bodies_of(frames, self.support))
            there &= touch
        return there

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)
