"""Review of a batch: findings, uncertain values and candidate values for a person, from report and records."""

from __future__ import annotations

import posixpath
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path, PurePosixPath
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict

from assetkit.batch.decisions import date_of_decision
from assetkit.options import METERS_PER_UNIT
from assetkit.package.record import RECORD, read_record
from assetkit.parts.human_labels import allowed_labels, region_key
from schemas.asset import AssetRecord
from schemas.asset import SourceFile as FileRead
from schemas.decision import DecidedField, Decision, PartLabel
from schemas.diagnostics import Diagnostic, Severity
from schemas.outcome import ItemOutcome
from schemas.parts import UNLABELLED, by_id
from schemas.report import ReportItem

DOUBTFUL = 0.5  # Evidence below this confidence is shown.
_UP_AXIS_TEXTS = {
    "x": "x is up",
    "y": "y is up, as in glTF and most OBJ files",
    "z": "z is up, as in most CAD and robot files",
}


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True)


class CandidateValue(_Model):
    """A value that could be set, what it would mean, and its probability where one is known."""

    value: str
    means: str
    confidence: float | None = None


class UncertainValue(_Model):
    """A value of low confidence in one package, the evidence for it, and candidate values. `field` can be set with the
    `flag`: one of the fields of a decision, or a part by its id.
    """

    package: str
    flag: Literal["set", "part"] = "set"
    field: str
    value: str
    confidence: float
    evidence: str
    candidates: tuple[CandidateValue, ...]


class ReviewItem(_Model):
    """One source with all that a person needs to decide about it; `pictures` are relative to the library."""

    source: str
    outcome: ItemOutcome
    packages: tuple[str, ...]
    findings: tuple[Diagnostic, ...]
    doubts: tuple[UncertainValue, ...]
    pictures: tuple[str, ...]
    decisions: tuple[Decision, ...]


def review_items(out: Path, items: Iterable[ReportItem], decisions: Sequence[Decision]) -> Iterator[ReviewItem]:
    """One review item per report item, in the order of `items`."""
    for item in items:
        records = _records(out, item)
        yield ReviewItem(
            source=item.source,
            outcome=item.outcome,
            packages=item.packages,
            findings=tuple(d for d in item.diagnostics if d.severity is not Severity.INFO),
            doubts=tuple(value for record in records for value in uncertain_values(record)),
            pictures=tuple(
                path.relative_to(out).as_posix()
                for record in records
                for path in sorted((out / record.asset_id / "previews").glob("*.png"))
            ),
            decisions=tuple(d for d in decisions if d.source == item.source),
        )


def uncertain_values(record: AssetRecord) -> tuple[UncertainValue, ...]:
    """The unit, up axis, category and parts of a record whose confidence is below `DOUBTFUL`."""
    source, semantics = record.source, record.semantics
    longest_units = max(record.geometry.extent_m.value) / source.meters_per_unit.value
    sizes = [
        CandidateValue(value=u, means=f"longest edge {_length(longest_units * s)}") for u, s in METERS_PER_UNIT.items()
    ]
    axes = [CandidateValue(value=axis, means=text) for axis, text in _UP_AXIS_TEXTS.items()]
    categories = [
        CandidateValue(value=h.category, means="; ".join(h.clues), confidence=h.score) for h in semantics.hypotheses
    ]
    unit = next((u for u, s in METERS_PER_UNIT.items() if s == source.meters_per_unit.value), "other")
    fields: tuple[tuple[DecidedField, str, float, str, list[CandidateValue]], ...] = (
        ("units", unit, source.meters_per_unit.confidence, source.meters_per_unit.method, sizes),
        ("up_axis", source.up_axis.value, source.up_axis.confidence, source.up_axis.method, axes),
        ("category", semantics.category.value, semantics.category.confidence, semantics.category.method, categories),
    )
    values = tuple(
        UncertainValue(
            package=record.asset_id, field=f, value=v, confidence=c, evidence=method, candidates=tuple(candidates)
        )
        for f, v, c, method, candidates in fields
        if c < DOUBTFUL
    )
    return (*values, *_uncertain_parts(record))


def _uncertain_parts(record: AssetRecord) -> Iterator[UncertainValue]:
    """Parts whose labels the clues contradict; each label that a clue supports is a candidate, and so is none."""
    for part in (p.value for p in record.parts if p.value.may_be):
        where = f"one of {len(record.parts)} parts, {_length(max(np.subtract(part.high_m, part.low_m)))} long"
        yield UncertainValue(
            package=record.asset_id,
            flag="part",
            field=part.part_id,
            value=part.label.value,
            confidence=part.label.confidence,
            evidence=f"{part.label.method}; {where}",
            candidates=tuple(
                CandidateValue(value=label, means=meaning)
                for label, meaning in (*((m, f"it is the {m}") for m in part.may_be), (UNLABELLED, "it is neither"))
            ),
        )


def items_called(items: Iterable[ReportItem], name: str) -> list[ReportItem]:
    """The items of a name: that of the source as given or of one of its packages; else all whose file has that name."""
    exact: list[ReportItem] = []
    namesakes: list[ReportItem] = []
    for item in items:
        if item.source == name or name in item.packages:
            exact.append(item)
        elif PurePosixPath(item.source).name == name:
            namesakes.append(item)
    return exact or namesakes


def decision_about(
    out: Path,
    item: ReportItem,
    name: str,
    *,
    set_: dict[DecidedField, str],
    accept: bool | None,
    parts: Mapping[str, str] = {},
    by: str,
    reason: str,
) -> Decision:
    """The decision on an item, bound to the content that it was made from. `name` selects objects where a file holds
    several: the name of a package selects one, that of the source all of them.

    Raises LookupError when no package was made that the decision could apply to, or it has no such part. Raises
    ValueError when its category has no part of that name.
    """
    single = name in item.packages
    about = [r for r in _records(out, item) if not single or r.asset_id == name]
    if not about:
        raise LookupError(f"'{name}' is {item.outcome.value}: there is no package to decide about")
    main = main_file(about[0].source.files, item.source)
    return Decision(
        source=item.source,
        source_sha256=main.sha256,
        references={
            posixpath.relpath(f.path, posixpath.dirname(main.path)): f.sha256
            for f in about[0].source.files
            if f != main
        },
        object=int(name.rpartition("-")[2]) if single and len(item.packages) > 1 else 0,
        set=set_,
        parts=_part_labels(about, parts),
        accept=accept,
        known=tuple(sorted({d.code for r in about for d in r.diagnostics})) if accept else (),
        by=by,
        reason=reason,
        date=date_of_decision(),
    )


def _part_labels(about: Sequence[AssetRecord], parts: Mapping[str, str]) -> dict[str, PartLabel]:
    if not parts:
        return {}
    if len(about) > 1:
        raise LookupError("the file holds several objects: name the package whose part is meant")
    known, names = by_id(about[0].parts), allowed_labels(about[0].semantics.category.value)
    for part, label in parts.items():
        if part not in known:
            raise LookupError(f"{about[0].asset_id} has no part '{part}', only {', '.join(known) or 'the whole'}")
        if label and label not in names:
            raise ValueError(f"a part of it is one of {', '.join(names)}, not '{label}'")
    return {part: PartLabel(label=label, region=region_key(known[part])) for part, label in parts.items()}


def main_file(files: Sequence[FileRead], source: str) -> FileRead:
    """The file that `source` names, of all that were read: the one that shares most trailing path parts with it."""

    def shared(file: FileRead) -> int:
        pairs = zip(reversed(PurePosixPath(file.path).parts), reversed(PurePosixPath(source).parts), strict=False)
        return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))

    return max(files, key=lambda file: (shared(file), -len(PurePosixPath(file.path).parts)))


def _records(out: Path, item: ReportItem) -> list[AssetRecord]:
    records = (read_record(out / package) for package in item.packages if (out / package / RECORD).is_file())
    return [record for record in records if record is not None]


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 1.0 else f"{1000 * metres:.3g} mm"
