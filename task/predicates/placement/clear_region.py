"""`clear_region`: nothing stands on a stretch of a surface."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.anchors import AnchorPolygon
from schemas.arrays import BoolArray
from task.frames import Frames
from task.polygons import in_polygon
from task.predicates.protocol import Instant, Metres, Object, Objects


class ClearRegion(Instant):
    """No corner or centre of the objects is over the outline, between the surface and `height_m` over it.

    `outline` has points (x, y) in the frame of the surface; without it the whole surface counts.
    """

    func: ClassVar[str] = "clear_region"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "surfaces"})
    support: Object
    things: Objects = Field(alias="objects")
    surface: str = Field(default="auto", description="an anchor of the record; the main surface by default")
    outline: tuple[tuple[float, float], ...] | None = Field(default=None, min_length=3)
    height_m: Metres = Field(default=0.3, description="what is higher over the surface does not count (m)")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        surface, body = frames.surface(self.support, self.surface)
        region = surface.polygon if self.outline is None else AnchorPolygon(outline_m=self.outline)
        clear = np.ones(len(frames), dtype=bool)
        for name in self.things:
            points = np.concatenate([frames.points(name), frames.centre(name)[:, None]], axis=1)
            local = frames.in_anchor(points, surface, body)
            over = in_polygon(local[..., 0], local[..., 1], region) & (local[..., 2] <= self.height_m)
            clear &= ~(over & (local[..., 2] >= -self.height_m)).any(axis=1)
        return clear
