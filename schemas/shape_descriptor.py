"""Rotation- and scale-invariant numbers of a surface, by which near-duplicates are looked up in a library."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class ShapeDescriptor(BaseModel):
    """Figures of a surface in units of `scale_m`, all area-weighted, so that the tessellation hardly matters.

    scale_m         root mean square distance of the surface from its area centroid.
    second_moments  principal second moments about the centroid, largest first; they add up to 1.
    third_moments   norm of the third-moment tensor and of its trace vector `v_i = T_ijj`.
    distances       quantiles of the distance between two random surface points (Osada et al. 2002, D2), at the middles
                    of equal shares.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    scale_m: float
    second_moments: tuple[float, float, float]
    third_moments: tuple[float, float]
    distances: tuple[float, ...]
