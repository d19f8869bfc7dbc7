"""The batch report outside tools rely on (design: stable JSON; extend, never rename)."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from schemas.diagnostics import Diagnostic, Severity
from schemas.outcome import EndpointUse, ItemOutcome, Repair


class ReportItem(BaseModel):
    """What became of one source. `source` is the path as given, joined with the path below it."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    source: str
    outcome: ItemOutcome
    codes: tuple[str, ...] = ()
    packages: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    seconds: dict[str, float] = {}
    cached: tuple[str, ...] = ()
    peak_memory_mb: float = 0.0
    endpoint: EndpointUse | None = None
    traceback: str = ""


class CodeCount(BaseModel):
    """A code that kept items from being accepted as they were: how many items of each outcome have it, and the first.

    `headline` and `help` are those of the example, the first item in the order of the report.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    code: str
    severity: Severity
    outcomes: dict[ItemOutcome, int]
    example: str
    headline: str
    help: str = ""

    @property
    def items(self) -> int:
        """Number of items that have the code."""
        return sum(self.outcomes.values())


class IngestReport(BaseModel):
    """`report.json` of `mana assets ingest`. Timings live here and nowhere else."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    schema_version: str = "1.0"
    items: tuple[ReportItem, ...]
    reasons: tuple[CodeCount, ...] = ()
    totals: dict[str, float]
    interrupted: bool = False
