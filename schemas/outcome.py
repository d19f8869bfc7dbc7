"""Results of stages and final outcomes of items, with repairs and the cost of network requests."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from pydantic import BaseModel, ConfigDict

from schemas.diagnostics import Diagnostic, Severity

T_co = TypeVar("T_co", covariant=True)
INTAKE = "intake"  # the stage under which readers record their repairs


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


class EndpointUse(BaseModel):
    """What asking a model over the network took. `from_store` counts answers that were already there and cost nothing;
    `usd` is None where no price was stated.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    requests: int = 0
    from_store: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    usd: float | None = None

    def __add__(self, other: EndpointUse) -> EndpointUse:
        known = [u.usd for u in (self, other) if u.usd is not None]
        return EndpointUse(
            requests=self.requests + other.requests,
            from_store=self.from_store + other.from_store,
            input_tokens=self.input_tokens + other.input_tokens,
            output_tokens=self.output_tokens + other.output_tokens,
            usd=sum(known) if known else None,
        )


@dataclass(frozen=True)
class ExternalAnswer:
    """What a stage learned from the world outside: a digest of it, on which all later results depend, and its price."""

    digest: str
    use: EndpointUse


@dataclass(frozen=True)
class Outcome(Generic[T_co]):
    """A stage's result: a value, or None when an error-severity diagnostic ended the item.

    `review` means that a person must decide; its diagnostics state the question. With `outside` the result does not
    follow from files and options alone, so it is not stored.
    """

    value: T_co | None
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False
    outside: ExternalAnswer | None = None

    @property
    def failed(self) -> bool:
        """True iff the item cannot go on."""
        return self.value is None or any(d.severity is Severity.ERROR for d in self.diagnostics)
