"""Samples of a plan as PyTorch tensors on one device (64-bit floats), without a copy from the host.

PyTorch is optional (`pip install torch`). Random words, and so all discrete choices, equal numpy's; poses (m, rad)
agree to 1e-6 or better, since a device may round a product and a sum once instead of twice.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from types import ModuleType
from typing import Any, cast

import numpy as np
import torch

from runtime_plan.counter_rng import FLOAT_STEP
from runtime_plan.philox import philox
from runtime_plan.plan import Plan
from runtime_plan.sampler import sample_with
from runtime_plan.samples import Samples


class Torch:
    """`runtime_plan.backend.Backend` on one device."""

    xp: ModuleType = torch

    def __init__(self, device: str) -> None:
        self.device = device

    def uniforms(self, seed: int, start: int, n: int, blocks: int) -> Any:
        """Uniform numbers from the words of numpy's Philox, computed on the device."""
        if (start + n) * blocks >= 2**63:
            raise ValueError(f"samples beyond 2**63 words are not drawn here: {start}")
        counter = torch.arange(n * blocks, device=self.device, dtype=torch.int64) + (start * blocks + 1)
        words = torch.stack(philox(counter, seed), -1).reshape(n, 4 * blocks)
        return ((words >> 11) & (2**53 - 1)).to(torch.float64) * FLOAT_STEP

    def full(self, shape: tuple[int, ...], value: float | int | bool) -> Any:
        """A tensor filled with one value."""
        kinds: dict[type, Any] = {bool: torch.bool, int: torch.int64}
        kind = kinds.get(type(value), torch.float64)
        return torch.full(shape, value, dtype=kind, device=self.device)

    def floor_to_int(self, values: Any) -> Any:
        """Round down to 64-bit integers."""
        return values.to(torch.int64)


class TorchSampler:
    """A plan on a device. `sample` returns the `Samples` of `runtime_plan.sampler` as tensors there."""

    def __init__(self, plan: Plan, device: str = "cpu") -> None:
        self._backend = Torch(device)
        self._tables = _on_device(plan.tables, device)

    def sample(self, n: int, seed: int, start: int = 0) -> Samples:
        """Samples `start` to `start + n - 1` of the stream `seed`."""
        return sample_with(self._backend, self._tables, n, seed, start, max(n, 1))


def _on_device(value: Any, device: str) -> Any:
    """A copy of the tables with every array as a tensor on the device."""
    if isinstance(value, np.ndarray):
        return torch.as_tensor(np.ascontiguousarray(cast(Any, value)), device=device)
    if isinstance(value, tuple):
        return tuple(_on_device(item, device) for item in cast(tuple[Any, ...], value))
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: _on_device(getattr(value, f.name), device) for f in fields(value)})
    return value
