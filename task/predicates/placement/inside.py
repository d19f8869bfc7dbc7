"""`inside`: an object lies in the inside of a receptacle, as the receptacle's record measures it."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.polygons import in_polygon, in_volume
from task.predicates.placement.placed import LEAST_TIP_COSINE, Placed
from task.predicates.protocol import Object, Share

BELOW_FLOOR_M = 0.003  # rest of a contact, and of a floor that is measured in layers


class Inside(Placed):
    """The centre of the object's box lies in the volume, in the frame of the receptacle, which is not tipped over.

    A box around a receptacle, as public suites use it, also holds what lies beside a tilted basket.
    """

    func: ClassVar[str] = "inside"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts", "volumes"})
    object: Object
    container: Object
    volume: str = Field(default="auto", description="an anchor of the record; the main volume by default")
    least_share: Share = Field(
        default=0.5, description="least share of the hull's corners under the rim and within the opening's outline"
    )

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        volume, body = frames.volume(self.container, self.volume)
        centre = frames.in_anchor(frames.centre(self.object)[:, None], volume, body)
        raised = centre + np.array([0.0, 0.0, BELOW_FLOOR_M])
        middle_in = in_volume(raised, volume)[:, 0]
        upright = frames.rotation(body)[:, 2, 2] >= LEAST_TIP_COSINE
        there = middle_in & upright
        if self.least_share == 0.0 or not there.any():
            return there
        corners = frames.in_anchor(frames.points(self.object), volume, body)
        within = (corners[..., 2] <= volume.height_m) & (corners[..., 2] >= -BELOW_FLOOR_M)
        within &= in_polygon(corners[..., 0], corners[..., 1], volume.opening)
        return there & (within.sum(axis=1) >= self.least_share * corners.shape[1])

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)
