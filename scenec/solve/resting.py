"""What a placed thing stands on and what it offers to stand on."""

from __future__ import annotations

from functools import cached_property
from math import pi, sqrt
from typing import TYPE_CHECKING

import shapely
from shapely.geometry.base import BaseGeometry

if TYPE_CHECKING:
    from scenec.solve.placed import Placed

CONTACT_M = 2e-4  # collision pieces of one level top differ by less
INSIDE = 0.25  # share of the radius of a footprint (as a disc) by which its middle lies within its support
GRAIN_M = 1e-6  # plans are written in whole micrometres


class Resting:
    """A placed thing as part of a pile, all in P: its feet, its tops, its middle."""

    def __init__(self, placed: Placed):
        self.placed, own = placed, placed.turned.shape.own
        self.slabs = placed.slabs[:own]
        self.low_m = min(low for _, low, _ in self.slabs)
        self.high_m = max(high for _, _, high in self.slabs)

    @cached_property
    def foot(self) -> BaseGeometry:
        """What it stands with."""
        return shapely.union_all([area for area, low, _ in self.slabs if low <= self.low_m + CONTACT_M])

    def top_at(self, height_m: float) -> BaseGeometry:
        """What it offers to stand on at a height, no more than a contact below it."""
        near = [area for area, _, high in self.slabs if -CONTACT_M <= high - height_m <= 2 * GRAIN_M]
        return shapely.union_all(near)

    @cached_property
    def footprint(self) -> BaseGeometry:
        """All that it covers, without what it carries."""
        return shapely.union_all([area for area, _, _ in self.slabs])

    @cached_property
    def middle(self) -> shapely.Point:
        """Centroid of the footprint."""
        return self.footprint.centroid

    @cached_property
    def room_m(self) -> float:
        """How far within its support the middle must lie."""
        return INSIDE * sqrt(self.footprint.area / pi)
