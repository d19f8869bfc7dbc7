"""Rule: textures are read in the colour space, and unpacked with the scale, that their use requires."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import feeding_shader, shader_id
from gate.subject.values import at, format_numbers, text, vector
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-texture-reader",
    "A texture is read in the wrong colour space or scale",
    "Roughness read as sRGB is off by half; normals that are not unpacked light everything from one side.",
    "read colours as sRGB and everything else raw; unpack normal maps with scale 2 and bias -1",
)
COLOURS = ("diffuseColor", "emissiveColor", "specularColor")
WRAPS = ("black", "clamp", "repeat", "mirror", "useMetadata")
NORMAL_SCALE, NORMAL_BIAS = (2.0, 2.0, 2.0, 1.0), (-1.0, -1.0, -1.0, 0.0)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per texture that feeds a colour raw, a number as sRGB, or a normal without unpacking it."""
    for prim in subject.shaders:
        if shader_id(prim) != "UsdPreviewSurface":
            continue
        for shader_input in UsdShade.Shader(prim).GetInputs():
            source = feeding_shader(shader_input)
            if source is not None and shader_id(source[0]) == "UsdUVTexture":
                yield from _reader(subject, source[0], source[1], shader_input.GetBaseName())
    for prim in subject.shaders:
        if shader_id(prim) == "UsdUVTexture":
            yield from _values(prim)


def _reader(subject: Subject, prim: Any, output: str, use: str) -> Iterator[Diagnostic]:
    where, space = at(prim), text(prim, "inputs:sourceColorSpace", "auto")
    # Alpha is never converted, so a colour picture may feed the opacity as it is.
    wrong = space == "raw" if use in COLOURS else space == "sRGB" and output != "a"
    if wrong:
        headline = f"the texture of {use} is read as {space}"
        bound, severity = "sRGB" if use in COLOURS else "raw", subject.suspect_severity
        yield finding(CODE, headline, where=where, value=space, bound=bound, severity=severity)
    if use == "normal":
        scale, bias = vector(prim, "inputs:scale", (1.0,) * 4), vector(prim, "inputs:bias", (0.0,) * 4)
        # Green may be flipped (DirectX normal maps), and a strength multiplies both x and y, but not z.
        centred = np.allclose(scale[:2], -2.0 * bias[:2]) and bool(np.all(scale[:2] != 0.0))
        unpacked = centred and np.allclose(scale[2], NORMAL_SCALE[2]) and np.allclose(bias[2], NORMAL_BIAS[2])
        floating = text(prim, "inputs:file").rstrip("@").endswith((".exr", ".hdr"))
        if not unpacked and not floating:
            headline = "the normal map is not unpacked from 0 .. 1 to -1 .. 1"
            value = f"scale {format_numbers(scale)}, bias {format_numbers(bias)}"
            bound = f"scale {format_numbers(np.array(NORMAL_SCALE))}, bias {format_numbers(np.array(NORMAL_BIAS))}"
            yield finding(CODE, headline, where=where, value=value, bound=bound, severity=subject.suspect_severity)


def _values(prim: Any) -> Iterator[Diagnostic]:
    for name, width in (("inputs:scale", 4), ("inputs:bias", 4), ("inputs:fallback", 4)):
        value = vector(prim, name, (0.0,) * width)
        if not np.all(np.isfinite(value)):
            yield finding(CODE, f"{name} is not finite", where=at(prim), value=format_numbers(value))
    space = text(prim, "inputs:sourceColorSpace", "auto")
    if space not in ("raw", "sRGB", "auto"):
        yield finding(CODE, "the colour space is unknown", where=at(prim), value=space, bound="raw, sRGB or auto")
    for name in ("inputs:wrapS", "inputs:wrapT"):
        wrap = text(prim, name, "useMetadata")
        if wrap not in WRAPS:
            bound, severity = ", ".join(WRAPS), Severity.WARNING
            yield finding(CODE, f"{name} is unknown", where=at(prim), value=wrap, bound=bound, severity=severity)


RULE = Rule(
    CODE,
    "colours sRGB, the rest raw (auto allowed outside packages); normal maps scale 2, bias -1",
    "UsdPreviewSurface specification; SimReady VM.TEX.003",
    check,
)
