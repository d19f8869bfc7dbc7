"""Check of the declared split into training and test trials: known ids, disjoint, enough trials."""

from __future__ import annotations

from collections.abc import Sequence

from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.measurement import MeasurementSpec
from simgap.recording.reading.yaml_text import YamlDocument

FEWEST_TRIALS = 4  # Two to learn from, two to judge by.


def check_split(
    spec: MeasurementSpec, in_files: Sequence[str], usable: Sequence[str], document: YamlDocument
) -> tuple[Diagnostic, ...]:
    """Findings about `split`: ids without a file, ids on both sides, trials on neither, too few trials.

    `usable` are the ids of `in_files` that are left after the other checks.
    """
    findings: list[Diagnostic] = []
    if len(usable) < FEWEST_TRIALS:
        text = f"{len(usable)} trial{'s' * (len(usable) != 1)}; intervals by trial need at least {FEWEST_TRIALS}"
        findings.append(
            finding(
                "gap/too-few-trials",
                text,
                where=document.place(),
                value=len(usable),
                bound=FEWEST_TRIALS,
                unit="trials",
            )
        )
    split = spec.split
    if split is None:
        return tuple(findings)
    both = [i for i in split.train if i in set(split.test)]
    if both:
        text = f"{_named(both)} {'is' if len(both) == 1 else 'are'} in train and in test"
        where = document.place(("split", "test", split.test.index(both[0])))
        findings.append(finding("gap/split-leak", text, where=where, value=len(both), bound=0, unit="trials"))
    known = set(in_files)
    for part, ids in (("train", split.train), ("test", split.test)):
        unknown = [i for i in ids if i not in known]
        if unknown:
            where = document.place(("split", part, ids.index(unknown[0])))
            text = f"split.{part} names {_named(unknown)}; there is no such trial"
            findings.append(finding("gap/unknown-trial", text, where=where, value=len(unknown), bound=0, unit="trials"))
        elif not set(ids) & set(usable):
            where = document.place(("split", part), of_key=True)
            text = f"split.{part} has no usable trial"
            findings.append(finding("gap/too-few-trials", text, where=where, value=0, severity=Severity.ERROR))
    unused = [i for i in usable if i not in {*split.train, *split.test}]
    if unused:
        text = f"{_named(unused)} {'is' if len(unused) == 1 else 'are'} neither in train nor in test"
        findings.append(finding("gap/unused-trials", text, where=document.place(("split",), of_key=True)))
    return tuple(findings)


def _named(ids: Sequence[str]) -> str:
    shown = ", ".join(f"'{i}'" for i in ids[:3])
    return f"{shown} and {len(ids) - 3} more" if len(ids) > 3 else shown
