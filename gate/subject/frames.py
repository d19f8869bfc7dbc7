"""World transforms of prims at the default time, in metres: full matrices and nearest rigid poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Tf, UsdGeom

from gate.subject.values import TIME
from schemas.arrays import FloatArray
from usdio.read.stage_metadata import FALLBACK_METERS


@dataclass(frozen=True)
class Frames:
    """Transforms of one stage; `meters_per_unit` is 1 without a valid value (reported by the units rule)."""

    cache: Any
    meters_per_unit: float

    @classmethod
    def of(cls, stage: Any) -> Frames:
        """The frames of a composed stage."""
        root = stage.GetRootLayer().pseudoRoot
        stated = root.GetInfo("metersPerUnit") if root.HasInfo("metersPerUnit") else FALLBACK_METERS
        try:
            meters = float(stated)
        except (TypeError, ValueError):
            meters = 1.0
        return cls(UsdGeom.XformCache(TIME), meters if np.isfinite(meters) and meters > 0.0 else 1.0)

    def matrix(self, prim: Any) -> FloatArray:
        """(4, 4) from the prim's own coordinates, in stage units, to the world in metres; column vectors.

        NaN when OpenUSD cannot compute it (reported by the transform rule).
        """
        try:
            to_world = np.array(self.cache.GetLocalToWorldTransform(prim), dtype=np.float64).T
        except Tf.ErrorException:  # An operation holds a value of the wrong type.
            return np.full((4, 4), np.nan)
        to_world[:3] *= self.meters_per_unit
        return to_world

    def rigid(self, prim: Any) -> tuple[FloatArray, FloatArray]:
        """The pose X_WP (4, 4) in metres with scale and shear taken out, and the prim's axes (3, 3) with them.

        The nearest rotation is the polar factor (Higham 1988), from the singular value decomposition. NaN when the
        transform is not finite.
        """
        matrix = self.matrix(prim)
        linear = matrix[:3, :3] / self.meters_per_unit
        if not np.all(np.isfinite(matrix)):
            return np.full((4, 4), np.nan), linear
        u, _, vt = np.linalg.svd(linear)
        matrix[:3, :3] = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        return matrix, linear
