"""Rule: the longest visible edge lies in the size range of the labelled category."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.category import category_sizes, known_category, labels
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-category-size",
    "The asset is too large or too small for its category",
    "A mug of three metres has the wrong unit or the wrong label.",
    "check the unit of the source and the category label",
)
_FAR_FACTOR = 3.0  # times beyond the range: the unit or the label is wrong; below, it may be a toy or a giant


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when the longest visible edge is outside the range of the labelled category, if the table lists it."""
    points = subject.visible_points_W
    category = next((c for label in labels(subject.root).get("class", ()) if (c := known_category(label))), None)
    if category is None or len(points) == 0:
        return
    longest_m = float(np.ptp(points, axis=0).max())
    least_m, most_m = category_sizes()[category]
    if not least_m <= longest_m <= most_m:
        far = not least_m / _FAR_FACTOR <= longest_m <= most_m * _FAR_FACTOR
        yield finding(
            CODE,
            f"a {category} has another size",
            where=at(subject.root),
            value=longest_m,
            bound=least_m if longest_m < least_m else most_m,
            unit="m",
            severity=subject.suspect_severity if far else Severity.WARNING,
        )


RULE = Rule(CODE, "gate/subject/category_sizes.csv (error beyond 3 times the range)", "sizes of everyday things", check)
