"""Contact geometry of a placed thing: the area it stands on, the tops it offers, and its stability margin (metres,
P)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import pi, sqrt

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

CONTACT_M = 2e-4  # collision pieces of one level top differ by less
INSIDE = 0.25  # share of the radius of a footprint (as a disc) by which its middle lies within its support
GRAIN_M = 1e-6  # plans are written in whole micrometres


class ContactGeometry:
    """The prisms (outline, low, high) of one body in P, without what it carries, as part of a pile."""

    def __init__(self, prisms: Sequence[tuple[Polygon, float, float]]):
        self.prisms = prisms
        self.low_m = min(low for _, low, _ in self.prisms)
        self.high_m = max(high for _, _, high in self.prisms)

    @cached_property
    def foot(self) -> BaseGeometry:
        """The area on which it stands: outlines of all prisms that begin at its lowest height."""
        return shapely.union_all([area for area, low, _ in self.prisms if low <= self.low_m + CONTACT_M])

    def top_at(self, height_m: float) -> BaseGeometry:
        """The area on which others can stand at a height: tops no more than a contact below it."""
        near = [area for area, _, high in self.prisms if -CONTACT_M <= high - height_m <= 2 * GRAIN_M]
        return shapely.union_all(near)

    @cached_property
    def footprint(self) -> BaseGeometry:
        """Union of all its outlines."""
        return shapely.union_all([area for area, _, _ in self.prisms])

    @cached_property
    def middle(self) -> shapely.Point:
        """Centroid of the footprint."""
        return self.footprint.centroid

    @cached_property
    def stability_margin_m(self) -> float:
        """How far within its support the middle must lie."""
        return INSIDE * sqrt(self.footprint.area / pi)
