"""Which way is up? Declared axes are used; a comment can overrule a format's mere habit."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from assetkit.options import UpAxisName
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Axis, FloatArray
from schemas.outcome import Repair

_STATEMENT = re.compile(r"\b([xyz])[\s_-]*(?:axis)?[\s_-]*(?:is\s+)?up\b|\bup[\s_-]*(?:axis)?\s*[:=]?\s*\+?([xyz])\b")

# Rotations that bring the named source axis onto +z; cyclic or quarter turns, so handedness is kept.
TO_Z_UP: dict[Axis, FloatArray] = {
    "x": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True)
class UpDecision:
    """The source's up axis with its evidence, and what the user should know."""

    axis: Evidence[Axis]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def decide_up_axis(stated: Evidence[Axis], hints: tuple[str, ...], chosen: UpAxisName = "auto") -> UpDecision:
    """The up axis of the source: said by the user, declared by the file, stated in a comment, or the format's habit."""
    if chosen != "auto":
        return UpDecision(Evidence[Axis](value=chosen, source="declared", method=f"--up-axis {chosen}", confidence=1.0))
    if stated.source != "default":
        return UpDecision(stated)
    found = {a or b for a, b in _STATEMENT.findall("\n".join(hints).lower())}
    if len(found) != 1:
        return UpDecision(stated)
    axis: Axis = found.pop()
    evidence = Evidence[Axis](value=axis, source="inferred", method="comment or header of the file", confidence=0.9)
    if axis == stated.value:
        return UpDecision(evidence)
    note = finding(
        "asset/up-axis-mismatch",
        f"a comment says {axis} is up, the format's habit is {stated.value}",
        value=axis,
        bound=stated.value,
    )
    repair = Repair(
        name=f"up_axis_{axis}",
        code="asset/up-axis-mismatch",
        stage="canonicalize",
        before={"up_axis": stated.value},
        after={"up_axis": axis},
    )
    return UpDecision(evidence, (note,), (repair,))
