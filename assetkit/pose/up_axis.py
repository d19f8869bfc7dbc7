"""Up axis of a source, from the user, the file's declaration, statements in its texts, or the format's default."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.options import UpAxisName
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Axis
from schemas.outcome import Repair

_STATEMENT = re.compile(
    r"\b([xyz])[\s_-]*(?:axis)?[\s_-]*(?:is\s+)?up\b|\bup[\s_-]*(?:axis)?[\"']?\s*[:=]?\s*[\"']?\+?([xyz])\b"
)
_ORIGIN = re.compile(r"\bfrom\s+[+]?[xyz][\s_-]*(?:axis)?[\s_-]*up\b")  # "turned from y-up to z-up": the second counts.

MAX_TEXT = 100_000  # characters; comments are at the beginning of a file.

# Rotations that bring the named source axis onto +z; cyclic or quarter turns, so handedness is kept.
TO_Z_UP: dict[Axis, FloatArray] = {
    "x": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True)
class UpAxisDecision:
    """The source's up axis with its evidence, findings and repairs; `review`: a person must state the axis."""

    axis: Evidence[Axis]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False


def decide_up_axis(
    stated: Evidence[Axis], hints: Sequence[str], chosen: UpAxisName = "auto", chosen_by: str = "--up-axis"
) -> UpAxisDecision:
    """The up axis of the source: set by the user, declared by the file, stated in its texts, or the format's default.

    `stated` with source `declared` and confidence above 0.5 is declared by the file itself; with 0.5 or less it is
    implied by the format's standard.
    """
    if chosen != "auto":
        return UpAxisDecision(
            Evidence[Axis](value=chosen, source="declared", method=f"{chosen_by} {chosen}", confidence=1.0)
        )
    text = _ORIGIN.sub("", "\n".join(hints)[:MAX_TEXT].lower())
    axes = sorted({a or b for a, b in _STATEMENT.findall(text)})
    if stated.source != "default" and stated.confidence > 0.5:
        return UpAxisDecision(stated) if set(axes) <= {stated.value} else _overruling(stated, axes)
    if len(axes) > 1:
        note = _contradiction(f"the texts call {' and '.join(axes)} the up axis; say it with --up-axis", axes, stated)
        return UpAxisDecision(stated.model_copy(update={"confidence": 0.0}), (note,), review=True)
    if axes:
        return _from_texts(stated, axes[0])
    if stated.source != "default":
        return UpAxisDecision(stated)
    headline = f"nothing states which way is up; {stated.value} is taken"
    return UpAxisDecision(stated, (finding("asset/up-axis-unverified", headline, value=stated.value),))


def _overruling(stated: Evidence[Axis], text_axes: Sequence[str]) -> UpAxisDecision:
    """The declared axis, with a finding on the texts that contradict it."""
    headline = f"the file declares {stated.value} up, its texts say {' and '.join(text_axes)}; the declaration was used"
    note = _contradiction(headline, text_axes, stated)
    return UpAxisDecision(stated.model_copy(update={"confidence": min(stated.confidence, 0.8)}), (note,))


def _contradiction(headline: str, text_axes: Sequence[str], stated: Evidence[Axis]) -> Diagnostic:
    return finding("asset/contradictory-evidence", headline, value=", ".join(text_axes), bound=stated.value)


def _from_texts(stated: Evidence[Axis], text_axis: str) -> UpAxisDecision:
    """The axis that the texts state, in place of the format's default."""
    axis: Axis = "x" if text_axis == "x" else "y" if text_axis == "y" else "z"
    evidence = Evidence[Axis](value=axis, source="inferred", method="statement in the file's texts", confidence=0.9)
    if axis == stated.value:
        return UpAxisDecision(evidence)
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
    return UpAxisDecision(evidence, (note,), (repair,))
