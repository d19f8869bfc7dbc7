"""Counter-based random numbers: those of sample i are a function of seed and i alone (Philox4x64-10).

J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011; numpy's `Philox` with key = seed.
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray

FLOAT_STEP = 2.0**-53  # spacing of the numbers in [0, 1)


def uniforms(seed: int, start: int, n: int, blocks: int) -> FloatArray:
    """(n, 4 * blocks) numbers in [0, 1) of samples `start` onwards: the upper 53 bits of each word."""
    words = np.random.Philox(key=seed, counter=start * blocks).random_raw(n * 4 * blocks)
    words >>= np.uint64(11)
    return np.multiply(words, FLOAT_STEP, dtype=np.float64).reshape(n, 4 * blocks)
