"""The items of a running batch: on disk as they finish, so that memory does not grow with their number."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from schemas.diagnostics import Diagnostic, Severity
from schemas.outcome import EndpointUse, ItemOutcome
from schemas.report import CodeCount, ReportItem

_UNFINISHED = -1


class FinishedItems:
    """Takes items in the order in which they finish; gives them back, and figures over all, in the order of sources.

    A context manager: the file below `folder` that holds the items exists within it.
    """

    def __init__(self, folder: Path, count: int) -> None:
        self._path = folder / "items.jsonl"
        self._offsets = array("q", [_UNFINISHED]) * count
        self._outcomes: Counter[ItemOutcome] = Counter()
        self._counts: Counter[str] = Counter()
        self._seconds: Counter[str] = Counter()
        self._spent: EndpointUse | None = None
        self._reasons: dict[str, _ReasonCount] = {}

    def __enter__(self) -> Self:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._path.open("w+b")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()
        self._path.unlink(missing_ok=True)

    def __len__(self) -> int:
        return self._outcomes.total()

    def add(self, position: int, item: ReportItem) -> None:
        """Note the item of the source at `position`."""
        self._offsets[position] = self._file.seek(0, 2)
        self._file.write(item.model_dump_json().encode() + b"\n")
        self._outcomes[item.outcome] += 1
        unchanged = item.cached == ("item",)
        self._counts.update(packages=len(item.packages), cached=int(unchanged))
        self._seconds.update(item.seconds)
        if item.endpoint is not None and not unchanged:
            self._spent = (self._spent or EndpointUse()) + item.endpoint
        for diagnostic in item.diagnostics:
            if diagnostic.severity is not Severity.INFO:
                self._reasons.setdefault(diagnostic.code, _ReasonCount()).add(position, item, diagnostic)

    def lines(self) -> Iterator[bytes]:
        """The JSON of each finished item, in the order of the sources."""
        for offset in self._offsets:
            if offset != _UNFINISHED:
                self._file.seek(offset)
                yield self._file.readline().rstrip(b"\n")

    def __iter__(self) -> Iterator[ReportItem]:
        for line in self.lines():
            yield ReportItem.model_validate_json(line)

    def totals(self, wall_seconds: float) -> dict[str, float]:
        """Numbers of items, outcomes, packages and unchanged items, what an endpoint cost, and seconds per stage."""
        spent = {} if self._spent is None else self._spent.model_dump(exclude_none=True)
        return {
            "items": len(self),
            **{outcome.value: self._outcomes[outcome] for outcome in ItemOutcome},
            "packages": self._counts["packages"],
            "cached": self._counts["cached"],
            **{f"endpoint_{name}": round(value, 6) for name, value in spent.items()},
            "wall_seconds": round(wall_seconds, 2),
            **{f"{stage}_seconds": round(seconds, 2) for stage, seconds in sorted(self._seconds.items())},
        }

    def reasons(self) -> tuple[CodeCount, ...]:
        """Every code of warnings and errors, those of most rejected items first, then those of most items in review."""
        worst = (ItemOutcome.REJECTED, ItemOutcome.REVIEW)
        listed = [count.reason() for count in self._reasons.values()]
        return tuple(
            sorted(listed, key=lambda r: (*(-r.outcomes.get(outcome, 0) for outcome in worst), -r.items, r.code))
        )


class _ReasonCount:
    """Counts the items that have one code, and keeps the first of them as the example."""

    def __init__(self) -> None:
        self._outcomes: Counter[ItemOutcome] = Counter()
        self._example: tuple[int, str, Diagnostic] | None = None
        self._last = _UNFINISHED

    def add(self, position: int, item: ReportItem, diagnostic: Diagnostic) -> None:
        """Count the item once, however often it has the code."""
        if position == self._last:
            return
        self._last = position
        self._outcomes[item.outcome] += 1
        if self._example is None or position < self._example[0]:
            self._example = (position, item.source, diagnostic)

    def reason(self) -> CodeCount:
        """The counts with their example."""
        assert self._example is not None
        _, source, diagnostic = self._example
        return CodeCount(
            code=diagnostic.code,
            severity=diagnostic.severity,
            outcomes={outcome: self._outcomes[outcome] for outcome in ItemOutcome if self._outcomes[outcome]},
            example=source,
            headline=diagnostic.headline,
            help=diagnostic.help,
        )
