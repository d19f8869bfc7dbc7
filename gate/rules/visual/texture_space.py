"""Rule: pictures of MaterialX and MDL shaders are read in the colour space that their use requires."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from pxr import Sdf, UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import feeding_shader, is_material_x, is_mdl, shader_id
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-texture-space",
    "A picture of a MaterialX or MDL shader is read in the wrong colour space",
    "Colours read as data look washed out; roughness read as a colour is off by half.",
    "say srgb_texture (MaterialX) or sRGB (MDL) for colours, none or raw for everything else",
)
SURFACE: Final = "ND_open_pbr_surface_surfaceshader"
COLOUR_INPUTS: Final = (
    "base_color",
    "specular_color",
    "transmission_color",
    "subsurface_color",
    "coat_color",
    "fuzz_color",
    "emission_color",
)
COLOUR_PICTURES: Final = (
    "diffuse_texture",
    "emissive_color_texture",
    "glass_color_texture",
    "reflection_color_texture",
)
MATERIAL_X_COLOUR, MDL_COLOURS, DATA = "srgb_texture", ("sRGB", "srgb_texture", "auto", ""), ("none", "raw", "")
_DEEPEST = 32  # nodes between a surface and a picture


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per picture whose colour space does not fit what it feeds; each picture and use once."""
    for prim in subject.shaders:
        if is_mdl(prim):
            for port in UsdShade.Shader(prim).GetInputs():
                if port.GetTypeName() == Sdf.ValueTypeNames.Asset:
                    colour = port.GetBaseName() in COLOUR_PICTURES
                    yield from _judged(subject, port, port.GetBaseName(), colour, MDL_COLOURS if colour else ("raw",))
        elif shader_id(prim) == SURFACE:
            for port in UsdShade.Shader(prim).GetInputs():
                colour = port.GetBaseName() in COLOUR_INPUTS
                for file in _pictures(port, 0):
                    yield from _judged(
                        subject, file, port.GetBaseName(), colour, (MATERIAL_X_COLOUR,) if colour else DATA
                    )


def _judged(subject: Subject, file: Any, use: str, colour: bool, allowed: tuple[str, ...]) -> Iterator[Diagnostic]:
    space = str(file.GetAttr().GetColorSpace())
    if space not in allowed:
        headline = f"the picture of {use}, a {'colour' if colour else 'number'}, is read as {space or 'nothing stated'}"
        where, severity = at(file.GetPrim()), subject.suspect_severity
        yield finding(CODE, headline, where=where, value=space or "not stated", bound=allowed[0], severity=severity)


def _pictures(port: Any, depth: int) -> Iterator[Any]:
    """The `file` inputs of the MaterialX nodes upstream of an input."""
    source = feeding_shader(port) if depth < _DEEPEST else None
    if source is None or not is_material_x(shader_id(source[0])):
        return
    for upstream in UsdShade.Shader(source[0]).GetInputs():
        if upstream.GetBaseName() == "file" and upstream.GetTypeName() == Sdf.ValueTypeNames.Asset:
            yield upstream
        else:
            yield from _pictures(upstream, depth + 1)


RULE = Rule(
    CODE,
    "MaterialX: colours srgb_texture, the rest none or raw; MDL: colours sRGB, the rest raw",
    "SimReady VM.TEX.004, VM.TEX.005",
    check,
)
