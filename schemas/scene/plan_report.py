"""The verdict on samples that `mana plan verify --json` prints (design 11)."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class SampleViolation(_Model):
    """One rule that one sample breaks: the value found against its bound, in `unit`."""

    index: int
    kind: str
    things: tuple[str, ...]
    value: float
    bound: float
    unit: str
    label: str = ""


class PlanVerdict(_Model):
    """`invalid` counts samples; `violations` are those of the first of them."""

    checked: int
    invalid: int
    violations: tuple[SampleViolation, ...]
