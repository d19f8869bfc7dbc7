"""The envelope as a distance field on a grid (m, negative inside), for pictures and meshes, not for admission."""

from __future__ import annotations

import numpy as np

from replay.envelope.envelope import Envelope
from schemas.arrays import Float32Array, FloatArray

FAR_M = 0.05  # the field is no larger than this
_MOST_CELLS = 4_000_000


def signed_distance(envelope: Envelope, step_m: float) -> tuple[Float32Array, FloatArray, float]:
    """Field (x, y, z) of distances in metres, negative inside; the position (3,) of its first point; its step.

    The step is coarser than `step_m` where the grid would be too large. Each capsule is stamped into its own box.
    """
    radius = envelope.radius_m
    low = np.minimum(envelope.start_W, envelope.end_W) - radius[:, None] - step_m
    high = np.maximum(envelope.start_W, envelope.end_W) + radius[:, None] + step_m
    origin, extent = low.min(axis=0), high.max(axis=0) - low.min(axis=0)
    step_m = max(step_m, float((np.prod(extent) / _MOST_CELLS) ** (1.0 / 3.0)))
    field = np.full(np.ceil(extent / step_m).astype(int) + 1, FAR_M, dtype=np.float32)
    first = np.floor((low - origin) / step_m).astype(int)
    last = np.minimum(np.ceil((high - origin) / step_m).astype(int) + 1, field.shape)
    for k in range(len(radius)):
        box = tuple(slice(a, b) for a, b in zip(first[k], last[k], strict=True))
        axes = [origin[d] + step_m * np.arange(first[k, d], last[k, d]) for d in range(3)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1) - envelope.start_W[k]
        along = envelope.end_W[k] - envelope.start_W[k]
        share = np.clip(points @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
        away = np.linalg.norm(points - share[..., None] * along, axis=-1) - radius[k]
        np.minimum(field[box], away, out=field[box], casting="same_kind")
    return field, origin, step_m
