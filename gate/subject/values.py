"""Typed attribute values of untrusted files: a wrong type reads as NaN, an absent value as the fallback."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Usd

from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Location

EXTENT_TOLERANCE = 0.01  # of its longest edge: authored extents are rounded or of another tessellation
STATED_TOLERANCE = 1e-3  # relative, between two statements of one quantity: USD keeps single precision
TIME = Usd.TimeCode.EarliestTime()  # The default value, or the first sample where there is nothing else.


def at(prim: Usd.Prim) -> Location:
    """The location of a prim."""
    return Location(prim=str(prim.GetPath()))


def raw(prim: Usd.Prim, name: str) -> Any:
    """The value of an attribute, the schema's fallback included; None when there is none."""
    attribute = prim.GetAttribute(name)
    return attribute.Get(TIME) if attribute else None


def authored(prim: Usd.Prim, name: str) -> bool:
    """True iff some layer states a value for the attribute."""
    attribute = prim.GetAttribute(name)
    return bool(attribute) and attribute.HasAuthoredValue()


def number(prim: Usd.Prim, name: str, fallback: float = np.nan) -> float:
    """The value as a float."""
    value = raw(prim, name)
    if value is None:
        return fallback
    try:
        return float(value)
    except (TypeError, ValueError):
        return np.nan


def flag(prim: Usd.Prim, name: str, *, fallback: bool) -> bool:
    """The value as a truth value."""
    value = raw(prim, name)
    return fallback if value is None else bool(value)


def text(prim: Usd.Prim, name: str, fallback: str = "") -> str:
    """The value as a string."""
    value = raw(prim, name)
    return fallback if value is None else str(value)


def vector(prim: Usd.Prim, name: str, fallback: tuple[float, ...]) -> FloatArray:
    """The value as floats, as many as the fallback has; all NaN when it has another shape."""
    value = raw(prim, name)
    if value is None:
        return np.array(fallback, dtype=np.float64)
    return _floats(value, len(fallback))


def quaternion(prim: Usd.Prim, name: str) -> FloatArray:
    """(4,) the value in wxyz order; identity when absent."""
    value = raw(prim, name)
    if value is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    if isinstance(value, Gf.Quatf | Gf.Quatd | Gf.Quath):
        return np.array([value.GetReal(), *value.GetImaginary()], dtype=np.float64)
    return np.full(4, np.nan)


def rows(prim: Usd.Prim, name: str, width: int) -> FloatArray:
    """(n, width) the values of an array attribute; empty when absent or of another shape."""
    value = raw(prim, name)
    try:
        return np.asarray(value if value is not None else [], dtype=np.float64).reshape(-1, width)
    except (TypeError, ValueError):
        return np.zeros((0, width))


def integers(prim: Usd.Prim, name: str) -> IntArray:
    """(n,) int64 values of an array attribute; empty when absent or of another type."""
    value = raw(prim, name)
    try:
        return np.asarray(value if value is not None else [], dtype=np.int64).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0, dtype=np.int64)


def format_numbers(values: FloatArray) -> str:
    """Numbers as a short text, for a diagnostic."""
    return "(" + ", ".join(f"{float(v):.6g}" for v in np.ravel(values)) + ")"


def _floats(value: Any, length: int) -> FloatArray:
    try:
        array = np.asarray(value, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        return np.full(length, np.nan)
    return array if len(array) == length else np.full(length, np.nan)
