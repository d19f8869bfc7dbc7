"""Rule: vendor attributes (PhysX, Newton, MuJoCo) hold no NaN."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-nonfinite-value",
    "An engine parameter is not a number",
    "NaN spreads through a solver in one step.",
    "remove the attribute or give it a number",
)
VENDORS = ("physx", "newton:", "mjc:", "limit:", "state:")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per vendor attribute that holds NaN; infinity often means "no limit" and passes."""
    for attribute in subject.attributes:
        name = attribute.GetName()
        if name.startswith(VENDORS) and _holds_nan(attribute.Get(TIME)):
            yield finding(CODE, f"{name} is not a number", where=at(attribute.GetPrim()), value=np.nan)


def _holds_nan(value: Any) -> bool:
    if isinstance(value, str | bool) or value is None:
        return False
    try:
        return bool(np.isnan(np.asarray(value, dtype=np.float64)).any())
    except (TypeError, ValueError):
        return False


RULE = Rule(CODE, "no NaN", "IEEE 754: NaN fails every comparison an engine makes", check)
