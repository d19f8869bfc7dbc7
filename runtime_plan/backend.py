"""The interface to the array library of the sampler, and its default, numpy.

A backend makes the random numbers and the arrays; arithmetic goes through `xp`, a module with numpy's names.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, Protocol

import numpy as np

from runtime_plan.counter_rng import uniforms

Array = Any


class Backend(Protocol):
    """Operations that array libraries spell differently.

    `xp` has `maximum`, `minimum`, `round`, `searchsorted`, `sqrt`, `take`.
    """

    xp: ModuleType

    def uniforms(self, seed: int, start: int, n: int, blocks: int) -> Array:
        """(n, 4 * blocks) numbers in [0, 1); the same as `runtime_plan.counter_rng.uniforms`."""
        ...

    def full(self, shape: tuple[int, ...], value: float | int | bool) -> Array:
        """An array filled with one value: 64-bit integers, 64-bit floats or booleans by the type of the value."""
        ...

    def floor_to_int(self, values: Array) -> Array:
        """Round non-negative numbers down to 64-bit integers."""
        ...


class Numpy:
    """The default backend."""

    xp: ModuleType = np

    def uniforms(self, seed: int, start: int, n: int, blocks: int) -> Array:
        """See `runtime_plan.counter_rng`."""
        return uniforms(seed, start, n, blocks)

    def full(self, shape: tuple[int, ...], value: float | int | bool) -> Array:
        """An array filled with one value."""
        return np.full(shape, value)

    def floor_to_int(self, values: Array) -> Array:
        """Round down to 64-bit integers."""
        return values.astype(np.int64)


NUMPY = Numpy()
