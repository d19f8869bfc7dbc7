"""Philox4x64-10 in 64-bit integers with a sign, which wrap: for array libraries that have no unsigned ones.

J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011. The words are those of numpy's `Philox`.
"""

from __future__ import annotations

from typing import Any

Array = Any
_MULTIPLIERS = (0xD2E7470EE14C6C93, 0xCA5A826395121157)
_WEYL = (0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B)
_HALF = 0xFFFFFFFF


def philox(counter: Array, seed: int) -> tuple[Array, Array, Array, Array]:
    """The four words of each block; `counter` (any shape) holds the low words of the counters, as numpy's after 1."""
    zero = counter * 0
    a, b, c, d = counter, zero, zero, zero
    keys = (seed, 0)
    for _ in range(10):
        high_a, low_a = _product(a, _MULTIPLIERS[0])
        high_c, low_c = _product(c, _MULTIPLIERS[1])
        a, b, c, d = high_c ^ b ^ _signed(keys[0]), low_c, high_a ^ d ^ _signed(keys[1]), low_a
        keys = (keys[0] + _WEYL[0], keys[1] + _WEYL[1])
    return a, b, c, d


def _product(values: Array, by: int) -> tuple[Array, Array]:
    """Upper and lower 64 bits of the product of unsigned words, by halves of 32 bits."""
    low, high = values & _HALF, _upper(values)
    by_low, by_high = by & _HALF, by >> 32
    crossed, other = low * by_high, high * by_low
    middle = _upper(low * by_low) + (crossed & _HALF) + (other & _HALF)
    return high * by_high + _upper(crossed) + _upper(other) + _upper(middle), values * _signed(by)


def _upper(values: Array) -> Array:
    """The upper 32 bits as a number of at least 0."""
    return (values >> 32) & _HALF


def _signed(word: int) -> int:
    """The same 64 bits read with a sign."""
    word &= 2**64 - 1
    return word - 2**64 if word >= 2**63 else word
