"""Rule: shader inputs lie in the range their shader is defined for."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
from pxr import UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import constant_value, own_value, shader_id
from gate.subject.values import at, format_numbers, rows
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-shader-value",
    "A shader value is out of range",
    "Outside its range a shader is undefined: surfaces glow, turn black or reflect more light than they get.",
    "clamp the value to the range named",
)
_SHADER_ROUNDING = 1e-4


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per constant shader input outside its range or NaN, and per display colour or opacity outside 0 .. 1.

    The value of an input that a texture feeds is never read, so that it is worth a warning at most.
    """
    for prim in subject.shaders:
        ranges = shader_ranges().get(shader_id(prim), {})
        for shader_input in UsdShade.Shader(prim).GetInputs():
            bounds = ranges.get(shader_input.GetBaseName(), (-np.inf, np.inf))
            constant, unread = constant_value(shader_input), own_value(shader_input)
            value = unread if constant is None else constant
            if value is None or _within(value, *bounds):
                continue
            grave = subject.suspect_severity if np.all(np.isfinite(value)) else Severity.ERROR
            yield finding(
                CODE,
                f"{shader_input.GetBaseName()} is out of range",
                where=at(prim),
                value=format_numbers(value) if len(value) > 1 else float(value[0]),
                bound=f"{bounds[0]:g} .. {bounds[1]:g}",
                severity=Severity.WARNING if constant is None else grave,
            )
    for prim in subject.visible_prims:
        for name, width in (("primvars:displayColor", 3), ("primvars:displayOpacity", 1)):
            values = rows(prim, name, width)
            if len(values) and not _within(values, 0.0, 1.0):
                low, high = float(values.min()), float(values.max())
                headline = f"{name} is out of range"
                value, severity = f"{low:g} .. {high:g}", subject.suspect_severity
                yield finding(CODE, headline, where=at(prim), value=value, bound="0 .. 1", severity=severity)


@cache
def shader_ranges() -> dict[str, dict[str, tuple[float, float]]]:
    """Shader id -> input -> (least, most), from `shader_ranges.csv`."""
    table: dict[str, dict[str, tuple[float, float]]] = {}
    with Path(__file__).with_name("shader_ranges.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            table.setdefault(row["shader"], {})[row["input"]] = (float(row["least"]), float(row["most"]))
    return table


def _within(values: np.ndarray, least: float, most: float) -> bool:
    return bool(
        np.all((values >= least - _SHADER_ROUNDING) & (values <= most + _SHADER_ROUNDING) & np.isfinite(values))
    )


RULE = Rule(
    CODE,
    "finite; the ranges in gate/rules/visual/shader_ranges.csv",
    "UsdPreviewSurface specification; OpenPBR; OmniPBR",
    check,
)
