"""Normal maps of known height fields, for tests of normal maps."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray


def bumps(side: int, seed: int = 0, waves: int = 40) -> FloatArray:
    """Heights (side, side) in texels, rows against v: waves of random directions, as long as 4 to 16 texels."""
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(side), -np.arange(side))
    heights = np.zeros((side, side))
    for _ in range(waves):
        length, angle, phase = rng.uniform(4, 16), rng.uniform(0, np.pi), rng.uniform(0, 2 * np.pi)
        k = 2 * np.pi / length
        heights += 0.1 / k * np.cos(k * (u * np.cos(angle) + v * np.sin(angle)) + phase)
    return heights


def normal_map(heights: FloatArray, green: float = 1.0) -> np.ndarray:
    """The map (h, w, 3) of 8 bits; `green` -1 lets green point down along v (DirectX)."""
    slope_v, slope_u = -np.gradient(heights, axis=0), np.gradient(heights, axis=1)
    normals = np.stack([-slope_u, -green * slope_v, np.ones_like(heights)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.round((normals * 0.5 + 0.5) * 255.0).astype(np.uint8)
