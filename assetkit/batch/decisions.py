"""Decisions of people about sources: an append-only file, whose entries apply to every ingest of the same content."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import get_args

from pydantic import ValidationError

from assetkit.annotate.annotator import UNKNOWN
from assetkit.options import Options, UnitName, UpAxisName
from assetkit.sources.discover import SourceAsset
from jobs.cache import file_sha256
from schemas.asset import Role
from schemas.decision import Decision
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding

DECISIONS = "decisions.jsonl"
# Fields that take only certain values; an empty text withdraws any of them.
ALLOWED: dict[str, tuple[str, ...]] = {
    "role": get_args(Role),
    "units": get_args(UnitName),
    "up_axis": get_args(UpAxisName),
}


def read_decisions(out: Path) -> tuple[Decision, ...]:
    """All decisions of an output folder, oldest first; () where there are none.

    Raises InvalidInput (`asset/decision-unreadable`) with the line that is no decision: leaving it out silently would
    undo somebody's decision.
    """
    path = out / DECISIONS
    if not path.is_file():
        return ()
    decisions = []
    for number, line in enumerate(path.read_bytes().splitlines(), start=1):
        try:
            decisions.append(_checked(Decision.model_validate_json(line)))
        except ValueError as error:
            first = error.errors()[0] if isinstance(error, ValidationError) else {"loc": ("set",), "msg": str(error)}
            reason = ".".join(str(p) for p in first["loc"]) + f" {first['msg']}"
            where = Location(file=DECISIONS, line=number)
            headline = f"{DECISIONS} line {number} is no decision: {reason.strip()}"
            raise InvalidInput(finding("asset/decision-unreadable", headline, where=where)) from error
    return tuple(decisions)


def _checked(decision: Decision) -> Decision:
    for field, value in decision.set.items():
        check_value(field, value)
    return decision


def check_value(field: str, value: str) -> None:
    """Raises ValueError when the field cannot have that value. An empty one withdraws what was stated."""
    if value and value not in ALLOWED.get(field, (value,)):
        raise ValueError(f"{field} must be one of {', '.join(ALLOWED[field])}")
    if field == "category" and value == UNKNOWN:
        raise ValueError("nobody can state that a category is unknown; leave the value empty to withdraw one")


def record_decision(decision: Decision, out: Path) -> None:
    """Append one decision. It is one write at the end of the file, under a lock on that file: people may decide at the
    same time, and while an ingest is at work, which reads the decisions when it starts.

    A file whose last line was left open, as by an editor, gets its line break first.
    """
    path = out / DECISIONS
    line = decision.model_dump_json(exclude_defaults=True).encode() + b"\n"
    with path.open("a+b", buffering=0) as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # For one read and one write; closing the file releases it.
        file.seek(0)
        present = file.read()
        unterminated = bool(present) and not present.endswith(b"\n")
        file.write(b"\n" + line if unterminated else line)


def date_of_decision() -> str | None:
    """The day of SOURCE_DATE_EPOCH, None where that is not set to a number: equal decisions give equal bytes."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    return datetime.fromtimestamp(int(epoch), UTC).date().isoformat() if epoch.isdecimal() else None


def with_decisions(options: Options, candidate: SourceAsset, decisions: Sequence[Decision]) -> Options:
    """The options of one source, with the decisions about its present content and those about earlier content.

    Sources that nobody decided about keep their options, and with them their stored results. Raises OSError when the
    file cannot be read.
    """
    if not decisions or not candidate.file.path.is_file():
        return options
    sha256 = file_sha256(candidate.file.path)
    about = [d for d in decisions if d.source_sha256 == sha256 and _has_references(candidate, d)]
    before = [d for d in decisions if d.source == candidate.given and d not in about]
    # A decision about the present content makes older ones about other content irrelevant.
    return options.model_copy(update={"decisions": tuple(about), "outdated": () if about else tuple(before)})


def _has_references(candidate: SourceAsset, decision: Decision) -> bool:
    folder = candidate.file.path.resolve().parent
    paths = {folder / name: sha for name, sha in decision.references.items()}
    return all(path.is_file() and file_sha256(path) == sha for path, sha in paths.items())


def decision_findings(batch: Options, number: int) -> tuple[Diagnostic, ...]:
    """Findings on the decisions about object `number` of a source: outdated, applied and overruled ones."""
    outdated = [
        finding(
            "asset/decision-outdated",
            f"the file has changed since {_who(d)} decided about it; the decision was not used",
            value=_summary(d),
        )
        for d in batch.outdated
        if d.object in (0, number)
    ]
    about = [d for d in batch.decisions if d.object in (0, number)]
    applied = [finding("asset/decided-by-person", f"{_who(d)} decided: {_summary(d)}{_reason(d)}") for d in about]
    return (*outdated, *applied, *_conflicts(batch, about))


def _conflicts(batch: Options, about: Sequence[Decision]) -> Iterable[Diagnostic]:
    """Statements that a later decision overrules, of earlier decisions and of the command line."""
    stated = [(_stated_values(d), _who(d)) for d in about]
    for field in dict.fromkeys(name for values, _ in stated for name in values):
        statements = [(values[field], who) for values, who in stated if field in values]
        flag = batch.model_dump().get(field)
        if flag not in (None, "auto"):
            statements.insert(0, (flag, f"--{field.replace('_', '-')}"))
        last_value, who = statements[-1]
        for value, other in statements[:-1]:
            if value != last_value:
                headline = f"{field}: '{last_value}' by {who} stands, '{value}' by {other} is overruled"
                yield finding("asset/decision-overruled", headline, value=last_value, bound=value)
    verdicts = [d for d in about if d.accept is not None]
    for earlier in verdicts[:-1]:
        if earlier.accept != verdicts[-1].accept:
            headline = f"'{_verdict(verdicts[-1])}' by {_who(verdicts[-1])} stands, not that of {_who(earlier)}"
            yield finding("asset/decision-overruled", headline)


def _verdict(decision: Decision) -> str:
    return "accepted as it is" if decision.accept else "acceptance withdrawn"


def _stated_values(decision: Decision) -> dict[str, str]:
    """The values that a decision states, by field name or part id."""
    return {**decision.set, **{part: label.label for part, label in decision.parts.items()}}


def _summary(decision: Decision) -> str:
    stated = _stated_values(decision).items()
    texts = [f"{field} is {value}" if value else f"{field} is not stated" for field, value in stated]
    return ", ".join([*texts, *([] if decision.accept is None else [_verdict(decision)])])


def _who(decision: Decision) -> str:
    return decision.by if decision.date is None else f"{decision.by} ({decision.date})"


def _reason(decision: Decision) -> str:
    return f" ({decision.reason})" if decision.reason else ""
