"""The array library that a draw works with: numpy, or whatever offers the same few functions under the same names."""

from __future__ import annotations

from types import ModuleType
from typing import Any, Protocol

import numpy as np

from runtime_plan.counter_rng import uniforms

Array = Any


class Backend(Protocol):
    """What differs between array libraries. `xp` has `maximum`, `minimum`, `round`, `searchsorted`, `sqrt`, `take`."""

    xp: ModuleType

    def uniforms(self, seed: int, start: int, n: int, blocks: int) -> Array:
        """(n, 4 * blocks) numbers in [0, 1); the same as `runtime_plan.counter_rng.uniforms`."""
        ...

    def full(self, shape: tuple[int, ...], value: float | int | bool) -> Array:
        """An array of one value: 64-bit integers, 64-bit floats or booleans as the value is."""
        ...

    def whole(self, values: Array) -> Array:
        """Numbers of at least 0 cut down to 64-bit integers."""
        ...


class Numpy:
    """The default."""

    xp: ModuleType = np

    def uniforms(self, seed: int, start: int, n: int, blocks: int) -> Array:
        """See `runtime_plan.counter_rng`."""
        return uniforms(seed, start, n, blocks)

    def full(self, shape: tuple[int, ...], value: float | int | bool) -> Array:
        """A filled array."""
        return np.full(shape, value)

    def whole(self, values: Array) -> Array:
        """Cut down."""
        return values.astype(np.int64)


NUMPY = Numpy()
