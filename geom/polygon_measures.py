"""Distances, areas and bounds of arrays of shapely geometries in the plane, as arrays of floats.

The one place where the functions of shapely are cast: its stubs leave their `**kwargs` without a type, which strict
checking reports at every call.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias, cast

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from schemas.arrays import FloatArray, ObjectArray

Geometries: TypeAlias = BaseGeometry | ObjectArray | Sequence[BaseGeometry]

_shapely = cast(Any, shapely)


def distances(a: Geometries, b: Geometries) -> FloatArray:
    """Smallest distances between the geometries of two arrays of shapes that broadcast."""
    return np.asarray(_shapely.distance(a, b), dtype=np.float64)


def areas(geometries: Geometries) -> FloatArray:
    """Areas (n,), 0 for points and lines."""
    return np.asarray(_shapely.area(geometries), dtype=np.float64)


def bounds(geometries: Geometries) -> FloatArray:
    """Least x, least y, greatest x, greatest y of each geometry, (n, 4); NaN for empty ones."""
    return np.asarray(_shapely.bounds(geometries), dtype=np.float64)
