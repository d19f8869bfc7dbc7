"""A derived value with its evidence: origin, method, confidence (0 to 1) and bounds."""

from __future__ import annotations

from typing import Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field

T = TypeVar("T")
BY_STANDARD = 0.5  # confidence of a value that the standard of a format gives because the file leaves it out
Source = Literal["declared", "measured", "inferred", "default"]


class Evidence(BaseModel, Generic[T]):
    """A value with its origin.

    `declared`: stated by a file or the user. `measured`: computed from the geometry or a simulation.
    `inferred`: concluded from indirect signs. `default`: unknown; `confidence` is then 0.
    `bounds` is `[low, high]` with the same shape and unit as `value`; randomisation downstream reads it.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    value: T
    source: Source
    method: str = ""
    confidence: float = Field(default=1.0, ge=0.0, le=1.0)
    bounds: tuple[T, T] | None = None
    inputs: tuple[str, ...] = ()


def declared(value: T, method: str, *, inputs: tuple[str, ...] = (), confidence: float = 1.0) -> Evidence[T]:
    """Evidence for what a source file or the user states."""
    return Evidence(value=value, source="declared", method=method, inputs=inputs, confidence=confidence)


def measured(value: T, method: str, *, confidence: float = 1.0, bounds: tuple[T, T] | None = None) -> Evidence[T]:
    """Evidence for what was computed from the asset itself."""
    return Evidence(value=value, source="measured", method=method, confidence=confidence, bounds=bounds)


def inferred(
    value: T,
    method: str,
    confidence: float,
    *,
    bounds: tuple[T, T] | None = None,
    inputs: tuple[str, ...] = (),
) -> Evidence[T]:
    """Evidence for a conclusion from indirect signs; `confidence` is mandatory."""
    return Evidence(value=value, source="inferred", method=method, confidence=confidence, bounds=bounds, inputs=inputs)


def default(value: T, method: str = "no evidence", *, bounds: tuple[T, T] | None = None) -> Evidence[T]:
    """A placeholder for an unknown value: confidence 0 by construction."""
    return Evidence(value=value, source="default", method=method, confidence=0.0, bounds=bounds)
