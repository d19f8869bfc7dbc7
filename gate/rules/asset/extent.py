"""Rule: the visible size is possible and equals `asset_extents` of the metadata."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import EXTENT_TOLERANCE, at, format_numbers
from geom.pose import apply, inverse
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-extent",
    "The visible size is impossible, unusual or differs from the stated one",
    "Scenes are laid out by the stated size; millimetres read as metres are 1000 times too large.",
    "correct the scale, or state the size the asset has",
)
POSSIBLE_LEAST_M, POSSIBLE_MOST_M = 1e-4, 1e4  # as `asset/scale-implausible`
USUAL_LEAST_M, USUAL_MOST_M = 0.999e-3, 50.0  # A grain of rice has 6 mm, an articulated bus 18 m.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when the longest visible edge is impossible or unusual, or `asset_extents` disagrees with it."""
    points = subject.visible_points_W
    if len(points) == 0:
        return  # Reported by the not-visible rule.
    X_WR, _ = subject.frames.rigid(subject.root)
    extent_m = np.ptp(apply(inverse(X_WR), points), axis=0)
    longest_m = float(extent_m.max())
    where = at(subject.root)
    if not USUAL_LEAST_M <= longest_m <= USUAL_MOST_M:
        possible = POSSIBLE_LEAST_M <= longest_m <= POSSIBLE_MOST_M
        small = longest_m < USUAL_LEAST_M
        least, most = (USUAL_LEAST_M, USUAL_MOST_M) if possible else (POSSIBLE_LEAST_M, POSSIBLE_MOST_M)
        yield finding(
            CODE,
            "the visible size is unusual: is the unit right?" if possible else "the visible size is impossible",
            where=where,
            value=longest_m,
            bound=least if small else most,
            unit="m",
            severity=Severity.WARNING if possible else Severity.ERROR,
        )
    stated = np.asarray(subject.metadata.get("asset_extents", extent_m), dtype=object)
    if stated.shape != (3,) or not _close(stated.astype(np.float64), extent_m):
        headline = "the metadata state another size than the visible one"
        value = format_numbers(stated) if stated.shape == (3,) else str(stated)
        yield finding(CODE, headline, where=where, value=value, bound=format_numbers(extent_m), unit="m")


def _close(stated: np.ndarray, extent_m: np.ndarray) -> bool:
    return float(np.abs(stated - extent_m).max()) <= EXTENT_TOLERANCE * float(extent_m.max())


RULE = Rule(
    CODE,
    "longest edge 1 mm .. 50 m (error beyond 0.1 mm .. 10 km); asset_extents within 1 %",
    "SimReady SR.004; sizes of things robots meet",
    check,
)
