"""Rule: semantic labels are well formed and agree with the metadata and the asset name."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.category import UNKNOWN, category_sizes, known_category, labels, words
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-label",
    "A semantic label is missing, malformed or contradicted",
    "Whoever trains on the labels learns the wrong thing.",
    "make the class label, the Wikidata code, the metadata and the name agree",
)
_QCODE = re.compile(r"Q[1-9][0-9]*")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per empty or malformed label on the default prim, and per label that metadata or name contradict."""
    root = subject.root
    if root.IsPseudoRoot():
        return
    where, labels_by_taxonomy = at(root), labels(root)
    for taxonomy, values in labels_by_taxonomy.items():
        if not values or not all(v.strip() for v in values):
            yield finding(CODE, f"the {taxonomy} label is empty", where=where, severity=subject.suspect_severity)
        elif taxonomy == "wikidata_qcode" and not all(_QCODE.fullmatch(v) for v in values):
            yield finding(
                CODE, "the Wikidata label is no Q-code", where=where, value=", ".join(values), bound="Q<number>"
            )
    if not subject.released:
        return
    for taxonomy, field in (("class", "category"), ("wikidata_qcode", "qcode")):
        values, stated = labels_by_taxonomy.get(taxonomy, ()), str(subject.metadata.get(field, ""))
        if not values:
            yield finding(CODE, f"there is no {taxonomy} label", where=where)
        elif stated and not any(_same(value, stated) for value in values):
            headline = f"the {taxonomy} label is not what the metadata state"
            yield finding(CODE, headline, where=where, value=", ".join(values), bound=stated)
    yield from _against_name(subject, labels_by_taxonomy.get("class", ()))


def _same(label: str, stated: str) -> bool:
    if _QCODE.fullmatch(stated):
        return label == stated
    return words(label) == words(stated) or {label, stated} <= set(UNKNOWN)


def _against_name(subject: Subject, values: tuple[str, ...]) -> Iterator[Diagnostic]:
    """`mug_03` labelled `chair`: two known things of sizes that exclude each other."""
    named = known_category(str(subject.metadata.get("asset_name", "")))
    for value in values:
        labelled = known_category(value)
        if named is None or labelled is None or words(labelled) in words(str(subject.metadata["asset_name"])):
            continue
        (low_a, high_a), (low_b, high_b) = category_sizes()[named], category_sizes()[labelled]
        if high_a < low_b or high_b < low_a:
            headline = f"the asset is named a {named} and labelled a {labelled}"
            yield finding(CODE, headline, where=at(subject.root), value=value, bound=named, severity=Severity.WARNING)


RULE = Rule(
    CODE,
    "labels present, well formed, equal to category and qcode in the metadata",
    "SimReady SL.001-003, SL.QCODE.001",
    check,
)
