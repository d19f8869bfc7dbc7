"""What a stage returns and what finally becomes of an item."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from pydantic import BaseModel, ConfigDict

from schemas.diagnostics import Diagnostic, Severity

T = TypeVar("T")


class ItemOutcome(StrEnum):
    """The four ends of an item (design: assets). Nothing vanishes."""

    ACCEPTED = "accepted"
    REPAIRED = "repaired"
    REVIEW = "review"
    REJECTED = "rejected"


class Repair(BaseModel):
    """One bounded edit, with the figures that justify it.

    `name` is the remedy (`hole_fill`, `flip_winding`, `unit_mm` ...), `code` the diagnostic it answers.
    `before` and `after` hold the same keys, units in the key names.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    name: str
    code: str
    stage: str
    before: dict[str, float | int | str] = {}
    after: dict[str, float | int | str] = {}


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """A stage's result: a value, or None when an error-severity diagnostic ended the item.

    `review` means that a person must decide; its diagnostics say what.
    """

    value: T | None
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False

    @property
    def failed(self) -> bool:
        """True iff the item cannot go on."""
        return self.value is None or any(d.severity is Severity.ERROR for d in self.diagnostics)
