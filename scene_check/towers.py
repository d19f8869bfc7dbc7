"""Stacks in which each object stands on the top of the one before it, for any masses (metres, in W).

The weights of all objects above a contact pass down through the centroids of their footprints. They balance for any
masses when each of these centroids lies over the hull of the contact; that of the object itself is `INSIDE` it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon

from scene_check.model import TOLERANCE_M, CheckObject, Violation
from scene_check.stacking import INSIDE, contact


def fallen_towers(stacks: Sequence[Sequence[str]], by_name: Mapping[str, CheckObject]) -> Iterator[Violation]:
    """Violations of objects of stacks that do not stand on the one below (the gap between them), or would tip (how far
    a centroid above is outside of the contact)."""
    for names in stacks:
        items = [by_name[name] for name in names]
        centroids = [shapely.union_all([Polygon(p.outline_m) for p in item.prisms]).centroid for item in items]
        for k, (lower, upper) in enumerate(pairwise(items), start=1):
            touched = contact(upper, lower)
            if touched.is_empty:
                gap = abs(upper.low_m - lower.high_m)
                yield Violation("unsupported", (upper.name, lower.name), max(gap, TOLERANCE_M), 0.0)
                continue
            support = touched.convex_hull
            footprint = shapely.union_all([Polygon(p.outline_m) for p in upper.prisms])
            inner = support.buffer(-INSIDE * float(np.sqrt(footprint.area / np.pi)))
            beyond = [float(centroids[k].distance(inner if not inner.is_empty else support.centroid))]
            beyond += [float(point.distance(support)) for point in centroids[k + 1 :]]
            if max(beyond) > TOLERANCE_M:
                yield Violation("unsupported", (upper.name, lower.name), max(beyond), 0.0)
