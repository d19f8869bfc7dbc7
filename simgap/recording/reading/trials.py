"""Groups the tables of a folder by trial and builds one value per trial; a bad file costs only its own trial."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from schemas.diagnostics import Diagnostic, InvalidInput, Label, Location, Severity, finding
from schemas.measurement import Kind
from simgap.recording.reading.push import part_of
from simgap.recording.reading.tables import Table, read_table

T = TypeVar("T")
Parts = Mapping[str, tuple[str, Table]]  # part name (empty: the whole trial) -> file name and table
_SHOWN = 5


def tables_by_trial(
    root: Path, paths: Sequence[Path], kind: Kind, columns: Collection[str]
) -> tuple[dict[str, Parts], tuple[Diagnostic, ...]]:
    """Every table under its trial's id (the file's stem), and findings: unreadable files and cells, one id twice."""
    trials: dict[str, dict[str, tuple[str, Table]]] = {}
    refused: list[Diagnostic] = []
    findings: list[Diagnostic] = []
    for path in paths:
        file = path.relative_to(root).as_posix()
        trial_id, part = part_of(path.stem) if kind == "push" else (path.stem, "")
        if part in trials.get(trial_id, {}):
            other = trials[trial_id][part][0]
            text = f"trial '{trial_id}' is also in {other}"
            findings.append(finding("gap/trial-id-twice", text, where=Location(file=file)))
            continue
        try:
            table = read_table(path, file, columns)
        except InvalidInput as bad:
            refused.append(bad.diagnostic)
            continue
        trials.setdefault(trial_id, {})[part] = (file, table)
        if table.bad_cells:
            text = f"{table.bad_cells} cells hold no number; their rows are treated as incomplete"
            where = table.first_bad or Location(file=file)
            findings.append(finding("gap/unreadable-cells", text, where=where, value=table.bad_cells, unit="cells"))
    return dict(trials), (*left_out(refused, bool(trials)), *findings)


def each(trials: Mapping[str, Parts], build: Callable[[str, Parts], T]) -> tuple[tuple[T, ...], tuple[Diagnostic, ...]]:
    """`build` over all trials; those that raise InvalidInput are left out and reported."""
    built: list[T] = []
    refused: list[Diagnostic] = []
    for trial_id, parts in trials.items():
        try:
            built.append(build(trial_id, parts))
        except InvalidInput as bad:
            refused.append(bad.diagnostic)
    return tuple(built), left_out(refused, bool(built))


def left_out(refused: Sequence[Diagnostic], any_left: bool) -> tuple[Diagnostic, ...]:
    """One finding per code for all refused files: a warning while others remain, else an error."""
    diagnostics: list[Diagnostic] = []
    for code in dict.fromkeys(d.code for d in refused):
        same = [d for d in refused if d.code == code]
        count = f"; {len(same)} file{'s' * (len(same) > 1)} left out" if any_left or len(same) > 1 else ""
        labels = tuple(Label(where=d.where, text=d.headline) for d in same[:_SHOWN])
        severity = Severity.WARNING if any_left else Severity.ERROR
        diagnostics.append(
            same[0].model_copy(
                update={"headline": same[0].headline + count, "severity": severity, "labels": labels * (len(same) > 1)}
            )
        )
    return tuple(diagnostics)
