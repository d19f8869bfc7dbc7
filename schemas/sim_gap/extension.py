"""`extension.json`: effects with their parameters and intervals, and where they act."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

Interval = tuple[float, float]


class Machine(BaseModel):
    """Of all documents of the sim gap."""

    # With one trial an interval's end is unknown: infinity is written as a word and read back.
    model_config = ConfigDict(frozen=True, extra="ignore", ser_json_inf_nan="strings")


class Estimate(Machine):
    """A value with its unit and 95 % interval."""

    value: float
    unit: str = "1"
    ci95: Interval


class Place(Machine):
    """Where an effect acts; all None means the whole world or log."""

    joint: str | None = None
    body: str | None = None
    pair: str | None = None

    def __str__(self) -> str:
        return self.joint or self.body or self.pair or "world"


class AppliedEffect(Machine):
    """One effect of a model extension."""

    name: str
    where: Place = Place()
    parameters: dict[str, Estimate]

    def values(self) -> dict[str, float]:
        """Parameter values alone, SI."""
        return {name: p.value for name, p in self.parameters.items()}


class ModelExtension(Machine):
    """`extension.json`: what `sim` adds to a world."""

    schema_version: Literal[1] = 1
    measurement: str
    target: dict[str, str] = {}
    effects: tuple[AppliedEffect, ...] = ()
