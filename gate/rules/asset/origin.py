"""Rule: the asset frame sits at the bottom centre of the object, untransformed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.body import diagonal
from gate.subject.values import at, format_numbers
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-origin",
    "The asset frame is not at the bottom centre of the object",
    "Scenes place the origin on a support; the object would float, sink or stand beside the spot.",
    "leave the default prim untransformed and move the points",
)
_ORIGIN_SHARE = 0.01  # of the diagonal


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package: a finding when the default prim is moved or turned, or the origin is not at the bottom centre."""
    if not subject.released or subject.root.IsPseudoRoot():
        return
    X_WR, _ = subject.frames.rigid(subject.root)
    if not np.allclose(X_WR, np.eye(4), atol=1e-6):
        position = format_numbers(X_WR[:3, 3])
        yield finding(CODE, "the default prim is moved or turned", where=at(subject.root), value=position, unit="m")
        return
    points = subject.visible_points_W
    if len(points) == 0:
        return
    low, high = points.min(axis=0), points.max(axis=0)
    bottom = np.array([*(0.5 * (low + high)[:2]), low[2]])
    bound_m = _ORIGIN_SHARE * diagonal(points)
    off_m = float(np.abs(bottom).max())
    if not off_m <= bound_m:
        yield finding(
            CODE,
            "the origin is not at the bottom centre of the visible surface",
            where=at(subject.root),
            value=off_m,
            bound=bound_m,
            unit="m",
        )


RULE = Rule(CODE, "default prim at identity; bottom centre within 1 % of the diagonal", "SimReady VG.025", check)
