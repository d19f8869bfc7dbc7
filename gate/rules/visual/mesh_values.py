"""Rule: points, normals and texture coordinates are finite."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import UsdGeom

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, rows
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-mesh-values",
    "A mesh holds NaN or infinity",
    "One such value poisons bounds, shading and contacts.",
    "find and fix the values in the array named",
)
ARRAYS = {"points": 3, "normals": 3, "extent": 3}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per array of a mesh that holds NaN or infinity."""
    for prim in subject.meshes:
        widths = {p.GetName(): _width(p) for p in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues()}
        for name, width in {**ARRAYS, **widths}.items():
            values = rows(prim, name, width) if width else rows(prim, name, 1)[:0]
            nonfinite = int((~np.isfinite(values)).any(axis=1).sum())
            if nonfinite:
                headline = f"{name} holds NaN or infinity"
                yield finding(CODE, headline, where=at(prim), value=nonfinite, bound=0, unit="values")


def _width(primvar: Any) -> int:
    """Numbers per value of a primvar of floats, 0 for another type."""
    value = primvar.GetTypeName().scalarType.defaultValue
    try:
        return int(np.asarray(value, dtype=np.float64).size)
    except (TypeError, ValueError):
        return 0


RULE = Rule(CODE, "finite", "a single NaN poisons bounds, shading and contacts", check)
