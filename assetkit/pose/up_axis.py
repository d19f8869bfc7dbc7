"""Which way is up? Declared axes are used; a statement in the texts decides only where the format is silent."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.options import UpAxisName
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Axis, FloatArray
from schemas.outcome import Repair

_STATEMENT = re.compile(
    r"\b([xyz])[\s_-]*(?:axis)?[\s_-]*(?:is\s+)?up\b|\bup[\s_-]*(?:axis)?[\"']?\s*[:=]?\s*[\"']?\+?([xyz])\b"
)
_ORIGIN = re.compile(r"\bfrom\s+[+]?[xyz][\s_-]*(?:axis)?[\s_-]*up\b")  # "turned from y-up to z-up": the second counts.

MAX_TEXT = 100_000  # characters; remarks stand at the beginning.

# Rotations that bring the named source axis onto +z; cyclic or quarter turns, so handedness is kept.
TO_Z_UP: dict[Axis, FloatArray] = {
    "x": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True)
class UpDecision:
    """The source's up axis with its evidence, and what the user should know; `review`: a person must say the axis."""

    axis: Evidence[Axis]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False


def decide_up_axis(
    stated: Evidence[Axis], hints: Sequence[str], chosen: UpAxisName = "auto", chosen_by: str = "--up-axis"
) -> UpDecision:
    """The up axis of the source: said by the user, declared by the file, stated in its texts, or the format's habit.

    `stated` with source `declared` and confidence above 0.5 is the file's own word; with 0.5 or less it is what the
    format's standard implies where the file is silent.
    """
    if chosen != "auto":
        return UpDecision(
            Evidence[Axis](value=chosen, source="declared", method=f"{chosen_by} {chosen}", confidence=1.0)
        )
    said = _ORIGIN.sub("", "\n".join(hints)[:MAX_TEXT].lower())
    found = sorted({a or b for a, b in _STATEMENT.findall(said)})
    if stated.source != "default" and stated.confidence > 0.5:
        return UpDecision(stated) if set(found) <= {stated.value} else _overruling(stated, found)
    if len(found) > 1:
        note = _contradiction(f"the texts call {' and '.join(found)} the up axis; say it with --up-axis", found, stated)
        return UpDecision(stated.model_copy(update={"confidence": 0.0}), (note,), review=True)
    if found:
        return _turned(stated, found[0])
    if stated.source != "default":
        return UpDecision(stated)
    headline = f"nothing states which way is up; {stated.value} is taken"
    return UpDecision(stated, (finding("asset/up-axis-unverified", headline, value=stated.value),))


def _overruling(stated: Evidence[Axis], found: Sequence[str]) -> UpDecision:
    """The declared axis against texts that say otherwise: it stands, and this is said."""
    headline = f"the file declares {stated.value} up, its texts say {' and '.join(found)}; the declaration was used"
    note = _contradiction(headline, found, stated)
    return UpDecision(stated.model_copy(update={"confidence": min(stated.confidence, 0.8)}), (note,))


def _contradiction(headline: str, found: Sequence[str], stated: Evidence[Axis]) -> Diagnostic:
    return finding("asset/contradictory-evidence", headline, value=", ".join(found), bound=stated.value)


def _turned(stated: Evidence[Axis], said: str) -> UpDecision:
    """The axis `said` in the texts, in place of the format's habit."""
    axis: Axis = "x" if said == "x" else "y" if said == "y" else "z"
    evidence = Evidence[Axis](value=axis, source="inferred", method="statement in the file's texts", confidence=0.9)
    if axis == stated.value:
        return UpDecision(evidence)
    note = finding(
        "asset/up-axis-mismatch",
        f"the texts of the file say {axis} is up, the format's habit is {stated.value}",
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
