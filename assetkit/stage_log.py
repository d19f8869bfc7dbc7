"""Log of one object: findings, repairs and timing by stage; a stage that runs again replaces its entry."""

from __future__ import annotations

from dataclasses import dataclass, field

from schemas.asset import RepeatedPass, StageEntry
from schemas.diagnostics import Diagnostic, Severity
from schemas.outcome import EndpointUse, ItemOutcome, Repair


@dataclass(frozen=True)
class Entry:
    """One stage's findings and time; `key` is its cache key, empty for steps that are not stored.

    `repeats` are the passes that ran again because of what the stage found, with the reasons.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False
    seconds: float = 0.0
    cached: bool = False
    version: int = 0
    key: str = ""
    endpoint: EndpointUse | None = None
    repeats: tuple[RepeatedPass, ...] = ()


@dataclass
class StageLog:
    """Entries by stage name, in the order of running. Written by the pipeline only."""

    entries: dict[str, Entry] = field(default_factory=dict[str, Entry])

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All findings of the entries."""
        return tuple(d for e in self.entries.values() for d in e.diagnostics)

    @property
    def repairs(self) -> tuple[Repair, ...]:
        """All edits that were made."""
        return tuple(r for e in self.entries.values() for r in e.repairs)

    @property
    def history(self) -> tuple[StageEntry, ...]:
        """The stored stages with version and key."""
        return tuple(
            StageEntry(name=name, version=e.version, key=e.key[:16], repeats=e.repeats)
            for name, e in self.entries.items()
            if e.key
        )

    @property
    def rejected(self) -> bool:
        """Whether an error-severity finding ended the object."""
        return any(d.severity is Severity.ERROR for d in self.diagnostics)

    @property
    def outcome(self) -> ItemOutcome:
        """The outcome of the object by the entries so far."""
        if self.rejected:
            return ItemOutcome.REJECTED
        if any(e.review for e in self.entries.values()):
            return ItemOutcome.REVIEW
        return ItemOutcome.REPAIRED if self.repairs else ItemOutcome.ACCEPTED

    def copy(self) -> StageLog:
        """An independent copy, for attempts."""
        return StageLog(dict(self.entries))
