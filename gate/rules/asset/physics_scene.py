"""Rule: a package has no physics scene; gravity elsewhere has a possible magnitude and points down."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom, UsdPhysics

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, format_numbers, number, vector
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-physics-scene",
    "The file brings its own gravity, or an impossible one",
    "Two scenes in one world compete; gravity that is zero, sideways or huge is rarely meant.",
    "leave the PhysicsScene to the world the asset is placed in",
)
LEAST_MPS2, MOST_MPS2 = 1.0, 30.0  # The Moon has 1.6, Jupiter 24.8.
_DOWNWARD_COSINE = 0.99  # cosine of about 8 degrees


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per PhysicsScene in a package, and per scene with impossible or sideways gravity."""
    up = np.eye(3)[1 if UsdGeom.GetStageUpAxis(subject.stage) == UsdGeom.Tokens.y else 2]
    for prim in subject.prims:
        if not prim.IsA(UsdPhysics.Scene):
            continue
        if subject.released:
            yield finding(CODE, "the package brings its own physics scene", where=at(prim))
        magnitude = number(prim, "physics:gravityMagnitude", -np.inf) * subject.frames.meters_per_unit
        if magnitude != -np.inf and not LEAST_MPS2 <= magnitude <= MOST_MPS2:
            possible = magnitude >= 0.0 and np.isfinite(magnitude)
            yield finding(
                CODE,
                "gravity is not that of any place robots work at" if possible else "gravity is impossible",
                where=at(prim),
                value=magnitude,
                bound=LEAST_MPS2 if magnitude < LEAST_MPS2 else MOST_MPS2,
                unit="m/s2",
                severity=Severity.WARNING if possible else Severity.ERROR,
            )
        direction = vector(prim, "physics:gravityDirection", (0.0, 0.0, 0.0))
        length = float(np.linalg.norm(direction))
        if not np.isfinite(length) or (length > 0.0 and -(up @ direction) < _DOWNWARD_COSINE * length):
            yield finding(
                CODE,
                "gravity does not point down",
                where=at(prim),
                value=format_numbers(direction),
                bound=format_numbers(-up),
                severity=Severity.WARNING if np.isfinite(length) else Severity.ERROR,
            )


RULE = Rule(CODE, "no scene in a package; 1 .. 30 m/s2 along -up", "SimReady Robotics-Prop; UsdPhysicsScene", check)
