"""Rule: the stage states metres, kilograms and z up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-units",
    "The package is not in metres, kilograms and z-up",
    "Simulators read the numbers as they stand; other units make every length and mass wrong.",
    "set metersPerUnit and kilogramsPerUnit to 1 and upAxis to Z, and convert the values",
)
EXPECTED: dict[str, float | str] = {"metersPerUnit": 1.0, "kilogramsPerUnit": 1.0, "upAxis": "Z"}
# What USD assumes where nothing is stated. A mass scale of 1 is harmless; centimetres and y-up are not.
FALLBACK: dict[str, float | str] = {"metersPerUnit": 0.01, "kilogramsPerUnit": 1.0, "upAxis": "Y"}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """One finding per unit or axis that is missing, impossible, or not the one released packages use."""
    root = subject.stage.GetRootLayer().pseudoRoot
    for name, expected in EXPECTED.items():
        if not root.HasInfo(name):
            yield from _missing(subject, name)
            continue
        value = root.GetInfo(name)
        if not _possible(value, expected):
            yield finding(CODE, f"{name} is {value}, which USD does not allow", value=str(value), bound=expected)
        elif value != expected:
            headline = f"{name} is {value}, not {expected} as in a released package"
            yield finding(CODE, headline, value=value, bound=expected, severity=subject.required_severity)


def _missing(subject: Subject, name: str) -> Iterator[Diagnostic]:
    """Where there is physics a missing length or axis is a guess about every number."""
    physical = bool(subject.bodies or subject.colliders) and FALLBACK[name] != EXPECTED[name]
    severity = subject.suspect_severity if physical else subject.required_severity
    if severity is not Severity.INFO:
        headline = f"{name} is not stated; USD then assumes {FALLBACK[name]}"
        yield finding(CODE, headline, value="absent", bound=EXPECTED[name], severity=severity)


def _possible(value: Any, expected: float | str) -> bool:
    if isinstance(expected, str):
        return str(value) in ("Y", "Z")
    return isinstance(value, int | float) and bool(np.isfinite(value)) and value > 0.0


RULE = Rule(CODE, "metersPerUnit 1, kilogramsPerUnit 1, upAxis Z, all stated", "SimReady UN.006, UN.007", check)
