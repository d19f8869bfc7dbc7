"""The batch report outside tools rely on (design: stable JSON; extend, never rename)."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from schemas.diagnostics import Diagnostic
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


class IngestReport(BaseModel):
    """`report.json` of `mana assets ingest`. Timings live here and nowhere else."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    schema_version: str = "1.0"
    items: tuple[ReportItem, ...]
    totals: dict[str, float]
    interrupted: bool = False
