"""Resolves a shader input through a UsdShade network to its source: a constant, an image or a primvar."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdShade

from schemas.appearance.material import Channel

EARLIEST: Final = Usd.TimeCode.EarliestTime()
MAX_SHADER_DEPTH: Final = 32
_FILE_INPUTS: Final = ("file", "filename", "texture")
_PASS_THROUGH_INPUTS: Final = ("in", "in1", "input", "fg", "default")
_CHANNELS: Final[dict[str, Channel]] = {
    "r": "r",
    "g": "g",
    "b": "b",
    "a": "a",
    "outr": "r",
    "outg": "g",
    "outb": "b",
    "outa": "a",
}
_WRAPS: Final = {"clamp": "clamp", "mirror": "mirror", "black": "black", "constant": "black"}


@dataclass(frozen=True)
class ImageSource:
    """One use of an image file. `file` is the attribute that holds the path; scale and bias act on RGBA texels.

    `primvar` names the texture coordinates, "" when the network names none. `fallback` replaces an absent image.
    """

    file: Usd.Attribute
    channel: Channel = "rgb"
    scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    bias: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    fallback: tuple[float, ...] | None = None
    wrap_s: str = "repeat"
    wrap_t: str = "repeat"
    primvar: str = ""
    uv_scale: tuple[float, float] = (1.0, 1.0)
    uv_rotation_rad: float = 0.0
    uv_offset: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class PrimvarSource:
    """A value read from a primvar of the mesh."""

    name: str


InputSource = float | bool | str | tuple[float, ...] | ImageSource | PrimvarSource | None


def input_source(port: UsdShade.Input) -> InputSource:
    """The source of `port`: a constant, an image, a primvar, or None when nothing is authored or none is found."""
    return _input_source(port, 0) if port else None


def to_json(value: Any) -> Any:
    """A USD value as JSON: vectors and arrays as lists, asset paths and tokens as text."""
    if isinstance(value, Sdf.AssetPath):
        return value.path
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return {str(k): to_json(v) for k, v in sorted(value.items())}
    if isinstance(value, Gf.Quatf | Gf.Quatd | Gf.Quath):
        return [value.GetReal(), *value.GetImaginary()]
    try:
        return [to_json(item) for item in value]
    except TypeError:
        return str(value)


def shader_identifier(shader: UsdShade.Shader) -> str:
    """The shader's id, or for an MDL source the name of its material."""
    prim = shader.GetPrim()
    for name in ("info:id", "info:mdl:sourceAsset:subIdentifier", "info:mdl:sourceAsset"):
        value = prim.GetAttribute(name).Get() if prim.HasAttribute(name) else None
        if value:
            return str(to_json(value))
    return ""


def _input_source(port: UsdShade.Input, depth: int) -> InputSource:
    if depth > MAX_SHADER_DEPTH:
        return None
    node = source_node(port)
    if node is not None:
        return _node_source(*node, depth)
    sources = UsdShade.Utils.GetValueProducingAttributes(port)
    value = sources[0].Get(EARLIEST) if sources else None
    is_file = isinstance(value, Sdf.AssetPath)
    return (ImageSource(sources[0]) if to_json(value) else None) if is_file else _constant(value)


def source_node(port: UsdShade.Input | UsdShade.Output) -> tuple[UsdShade.Shader, str] | None:
    """The shader, and the name of its output, that feeds `port` through any interfaces; None when a value does.

    Some exporters connect to outputs they never declare; the shader named by the connection counts then.
    """
    sources = UsdShade.Utils.GetValueProducingAttributes(port)
    if sources and UsdShade.Output.IsOutput(sources[0]):
        return UsdShade.Shader(sources[0].GetPrim()), sources[0].GetName().rpartition(":")[2]
    for path in port.GetAttr().GetConnections():
        prim = port.GetPrim().GetStage().GetPrimAtPath(path.GetPrimPath())
        if prim and prim.IsA(UsdShade.Shader) and not prim.HasProperty(path.name):
            return UsdShade.Shader(prim), path.name.rpartition(":")[2]
    return None


def _constant(value: Any) -> InputSource:
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, float | int):
        return _shortest(value)
    try:
        return tuple(_shortest(part) for part in value)
    except (TypeError, ValueError):
        return None


def _shortest(value: float) -> float:
    """The shortest decimal with the same single-precision value: shader inputs are floats, 0.4 stays 0.4."""
    return float(str(np.float32(value)))


def _node_source(shader: UsdShade.Shader, output: str, depth: int) -> InputSource:
    kind = shader_identifier(shader)
    if kind.startswith("UsdPrimvarReader") or "geompropvalue" in kind or "geomcolor" in kind:
        name = input_source(shader.GetInput("varname")) or input_source(shader.GetInput("geomprop"))
        return PrimvarSource(str(name or "displayColor"))
    if "constant" in kind.lower():
        return _input_source(shader.GetInput("value"), depth + 1)
    file = next((port for name in _FILE_INPUTS if (port := shader.GetInput(name))), None)
    if file is not None:
        image = _input_source(file, depth + 1)
        return _image_source(shader, image.file, kind, output) if isinstance(image, ImageSource) else _fallback(shader)
    return _arithmetic(shader, kind, depth) or _first_image_upstream(shader, output, depth)


def _arithmetic(shader: UsdShade.Shader, kind: str, depth: int) -> ImageSource | None:
    """The image that a MaterialX node multiplies by a constant, adds one to, or unpacks as normals; else None."""
    if kind.startswith("ND_normalmap"):
        image, strength = _input_source(shader.GetInput("in"), depth + 1), input_source(shader.GetInput("scale"))
        if isinstance(image, ImageSource) and not any(image.bias) and isinstance(strength, float):
            # As a UsdUVTexture that unpacks 0..1 to -1..1 does: scale 2, bias -1, times the strength in x and y.
            s = strength
            return replace(image, scale=(2.0 * s, 2.0 * s, 2.0, 1.0), bias=(-s, -s, -1.0, 0.0))
        return None
    operation = next((word for word in ("multiply", "add") if kind.startswith(f"ND_{word}_")), None)
    if operation is None:
        return None
    first, second = (_input_source(shader.GetInput(name), depth + 1) for name in ("in1", "in2"))
    image, constant = (first, second) if isinstance(first, ImageSource) else (second, first)
    if not isinstance(image, ImageSource) or not isinstance(constant, float | tuple):
        return None
    by = (constant,) * 4 if isinstance(constant, float) else (*constant, 1.0 if operation == "multiply" else 0.0)[:4]
    if len(by) < 4:
        return None
    if operation == "add":
        return replace(image, bias=tuple(bias + part for bias, part in zip(image.bias, by, strict=True)))
    scale = tuple(scale * part for scale, part in zip(image.scale, by, strict=True))
    return replace(image, scale=scale, bias=tuple(bias * part for bias, part in zip(image.bias, by, strict=True)))


def _first_image_upstream(shader: UsdShade.Shader, output: str, depth: int) -> InputSource:
    """The first image upstream of an arithmetic node; the node itself is not evaluated."""
    names = [port.GetBaseName() for port in shader.GetInputs()]
    ordered = sorted(
        names,
        key=lambda n: (_PASS_THROUGH_INPUTS.index(n) if n in _PASS_THROUGH_INPUTS else len(_PASS_THROUGH_INPUTS), n),
    )
    for name in ordered:
        source = _input_source(shader.GetInput(name), depth + 1)
        if isinstance(source, ImageSource):
            if output in _CHANNELS and source.channel == "rgb":
                return replace(source, channel=_CHANNELS[output])
            return source
    return None


def _image_source(shader: UsdShade.Shader, file: Usd.Attribute, kind: str, output: str) -> ImageSource:
    channel = _CHANNELS.get(output, "r" if kind.endswith("_float") else "rgb")
    names = ("wrapS", "wrapT") if "UsdUVTexture" in kind else ("uaddressmode", "vaddressmode")
    wraps = [_WRAPS.get(str(input_source(shader.GetInput(name))), "repeat") for name in names]
    where = _texture_coordinates(shader.GetInput("st") or shader.GetInput("texcoord"))
    tiling = input_source(shader.GetInput("uvtiling"))
    if isinstance(tiling, tuple) and len(tiling) == 2:
        where["uv_scale"] = tiling
    return ImageSource(
        file,
        channel,
        _four(input_source(shader.GetInput("scale")), 1.0),
        _four(input_source(shader.GetInput("bias")), 0.0),
        _fallback(shader),
        wraps[0],
        wraps[1],
        **where,
    )


def _texture_coordinates(port: UsdShade.Input) -> dict[str, Any]:
    """Primvar name and transform of the texture coordinates that feed `port`, as fields of `ImageSource`."""
    fields: dict[str, Any] = {}
    for _ in range(MAX_SHADER_DEPTH):
        node = source_node(port) if port else None
        if node is None:
            return fields
        shader = node[0]
        kind = shader_identifier(shader)
        if "UsdPrimvarReader" in kind or "geompropvalue" in kind:
            name = input_source(shader.GetInput("varname")) or input_source(shader.GetInput("geomprop"))
            return {**fields, "primvar": str(name)} if isinstance(name, str) else fields
        if kind.startswith("UsdTransform2d") and not fields:
            scale, offset = input_source(shader.GetInput("scale")), input_source(shader.GetInput("translation"))
            angle = input_source(shader.GetInput("rotation"))
            fields["uv_scale"] = scale if isinstance(scale, tuple) else (1.0, 1.0)
            fields["uv_offset"] = offset if isinstance(offset, tuple) else (0.0, 0.0)
            fields["uv_rotation_rad"] = math.radians(angle) if isinstance(angle, float) else 0.0
        if kind.startswith("ND_place2d") and not fields:
            fields |= _place2d(shader)
        port = shader.GetInput("in") or shader.GetInput("texcoord")
    return fields


def _place2d(shader: UsdShade.Shader) -> dict[str, Any]:
    """The transform of a MaterialX place2d node, which divides, turns clockwise and subtracts, as image fields."""
    scale, offset = input_source(shader.GetInput("scale")), input_source(shader.GetInput("offset"))
    angle = input_source(shader.GetInput("rotate"))
    sx, sy = scale if isinstance(scale, tuple) and len(scale) == 2 and all(scale) else (1.0, 1.0)
    ox, oy = offset if isinstance(offset, tuple) and len(offset) == 2 else (0.0, 0.0)
    turn = -math.radians(angle) if isinstance(angle, float) else 0.0
    return {"uv_scale": (1.0 / sx, 1.0 / sy), "uv_offset": (-ox, -oy), "uv_rotation_rad": turn}


def _fallback(shader: UsdShade.Shader) -> tuple[float, ...] | None:
    value = input_source(shader.GetInput("fallback"))
    return value if isinstance(value, tuple) else None


def _four(value: InputSource, default: float) -> tuple[float, ...]:
    if isinstance(value, tuple) and len(value) == 4 and np.isfinite(value).all():
        return value
    return (default,) * 4
