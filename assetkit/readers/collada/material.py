"""COLLADA effects as metallic-roughness materials. Source: COLLADA 1.4.1 specification, chapter 8 (profile_COMMON)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from assetkit.readers.collada.xml import Document, Element
from assetkit.readers.common.phong import (
    PHONG_CONFIDENCE,
    bare_metal,
    ior_or_default,
    linear_rgb,
    origins_of,
    roughness_from_exponent,
    unit_interval,
)
from assetkit.readers.common.texture_table import TextureTable, has_alpha, holds_normals
from schemas.appearance.material import Material, Origin, TextureUse
from schemas.diagnostics import Severity, finding

_SHADERS = ("phong", "blinn", "lambert", "constant")
_FLOATS = frozenset({"shininess", "reflectivity", "transparency", "index_of_refraction"})
_MAPPED = frozenset({"emission", "diffuse", "shininess", "transparency", "transparent"})
Wrap = Literal["repeat", "clamp", "mirror", "black"]
_WRAPS: dict[str, Wrap] = {"MIRROR": "mirror", "CLAMP": "clamp", "BORDER": "black", "NONE": "black"}


def read_material(
    name: str,
    material: Element,
    uv_index: dict[str, int],
    document: Document,
    textures: TextureTable,
    folder: Path,
) -> Material:
    """The `material` element as a Material called `name`; neutral where its effect is absent or empty.

    uv_index maps the texture-coordinate names of the effect to positions in `Mesh.uvs`. Colours are taken as display
    values. A texture in `diffuse` replaces the colour; unreadable values are dropped with a finding.
    """
    instance = material.find("instance_effect")
    effect = document.find(instance.get("url") if instance is not None else None, "effect")
    shader = None if effect is None else next((e for s in _SHADERS for e in effect.iter(s)), None)
    if effect is None or shader is None:
        return Material(name)
    colors, floats, uses = _values(name, shader, effect, uv_index, document, textures, folder)
    base = uses.get("diffuse")
    emission = uses.get("emission")
    mask = uses.get("transparent")
    opacity = 1.0 if mask else _opacity(name, shader, colors, floats, document)
    if mask:
        mask = replace(mask, channel="a" if has_alpha(textures.get(mask.texture)) else "r")
    metal = None if base or "specular" in uses else bare_metal(colors.get("diffuse"), colors.get("specular"))
    diffuse = linear_rgb(colors.get("diffuse", (0.8, 0.8, 0.8)))
    result = Material(
        name=name,
        base_color=(1.0, 1.0, 1.0) if base else metal or diffuse,
        base_color_texture=base,
        metallic=1.0 if metal else 0.0,
        roughness=_roughness(shader, colors, floats, specular_map="specular" in uses),
        normal_texture=_normal_map(effect, uv_index, document, textures, folder),
        normal_green="undeclared",
        emissive=(1.0, 1.0, 1.0) if emission else linear_rgb(colors.get("emission", (0.0, 0.0, 0.0))),
        emissive_texture=emission,
        opacity=opacity,
        opacity_texture=mask,
        alpha_mode="blend" if opacity < 1.0 or mask else "opaque",
        double_sided=any((e.text or "").strip() == "1" for e in effect.iter("double_sided")),
        ior=ior_or_default(floats.get("index_of_refraction")),
        unmapped=_unmapped(shader, colors, floats, uses),
        lost_textures=("base_color_texture",) if shader.find("diffuse/texture") is not None and not base else (),
    )
    tags = [*colors, *floats, *uses, *(["double_sided"] if result.double_sided else [])]
    stated = {tag: f"{shader.tag}: {tag}" for tag in tags}
    origins = origins_of(result, _ELEMENTS, stated, exponent="shininess", metal=metal is not None)
    if result.normal_texture is not None:
        origins["normal_texture"] = Origin("inferred", "bump, whose picture holds normals", PHONG_CONFIDENCE)
    return replace(result, origins=origins)


# The elements from which each field is made, the first that stands counts.
_ELEMENTS: dict[str, tuple[str, ...]] = {
    "base_color": ("diffuse",),
    "base_color_texture": ("diffuse",),
    "emissive": ("emission",),
    "emissive_texture": ("emission",),
    "opacity": ("transparent", "transparency"),
    "opacity_texture": ("transparent",),
    "alpha_mode": ("transparent", "transparency"),
    "double_sided": ("double_sided",),
    "ior": ("index_of_refraction",),
}


def _values(
    name: str,
    shader: Element,
    effect: Element,
    uv_index: dict[str, int],
    document: Document,
    textures: TextureTable,
    folder: Path,
) -> tuple[dict[str, tuple[float, ...]], dict[str, float], dict[str, TextureUse]]:
    """Colours, numbers and textures of a shader, by tag."""
    colors: dict[str, tuple[float, ...]] = {}
    floats: dict[str, float] = {}
    uses: dict[str, TextureUse] = {}
    for element in shader:
        texture = element.find("texture")
        if texture is not None:
            use = _texture_use(texture, effect, uv_index, document, textures, folder)
            if use is not None:
                uses[element.tag] = use
            continue
        value = _resolved(element, effect)
        if value is None:
            continue
        try:
            numbers = document.numbers(value)
        except ValueError:
            numbers = np.zeros(0)
        length = 1 if element.tag in _FLOATS else 3
        mistyped = length == 1 and value.tag == "color"
        if mistyped or len(numbers) < length or not np.isfinite(numbers).all():
            text = (value.text or "").strip()[:60]
            what = f"is a <{value.tag}>" if mistyped else f"'{text}' is not numeric"
            headline = f"material '{name}': {element.tag} {what}; the default is used"
            diagnostic = finding("asset/invalid-material-value", headline, where=document.place(value), value=text)
            document.report(diagnostic, "invalid_material_value", material=name, property=element.tag)
        elif length == 1:
            floats[element.tag] = float(numbers[0])
        else:
            colors[element.tag] = tuple(float(n) for n in numbers[:4])
    return colors, floats, uses


def _resolved(element: Element, effect: Element) -> Element | None:
    """The `float` or `color` below `element`, through a `param` reference if there is one."""
    for tag in ("float", "color"):
        if (value := element.find(tag)) is not None:
            return value
    param = element.find("param")
    target = None if param is None else _parameter(effect, param.get("ref") or "")
    if target is None:
        return None
    return next((e for e in target if e.tag.startswith("float")), None)


def _parameter(effect: Element, sid: str) -> Element | None:
    return next((p for p in effect.iter("newparam") if p.get("sid") == sid.strip()), None)


def _texture_use(
    texture: Element,
    effect: Element,
    uv_index: dict[str, int],
    document: Document,
    textures: TextureTable,
    folder: Path,
) -> TextureUse | None:
    """The texture a `texture` element names through sampler and surface, or (as old exporters do) by image id."""
    symbol = texture.get("texture") or ""
    sampler = _parameter(effect, symbol)
    source = None if sampler is None else sampler.find("sampler2D/source")
    surface = None if source is None else _parameter(effect, source.text or "")
    init = None if surface is None else surface.find("surface/init_from")
    instance = None if sampler is None else sampler.find("sampler2D/instance_image")  # COLLADA 1.5
    reference = instance.get("url") if instance is not None else (init.text if init is not None else symbol)
    image = document.find((reference or "").strip(), "image")
    where = document.place(texture)
    uri = "" if image is None else _image_uri(image)
    if not uri:
        textures.missing(symbol, where)
        return None
    name = textures.add(uri, base=folder, where=where)
    if name is None:
        return None
    return TextureUse(
        name,
        uv_set=uv_index.get(texture.get("texcoord") or "", 0),
        wrap_s=_wrap(sampler, "wrap_s"),
        wrap_t=_wrap(sampler, "wrap_t"),
    )


def _image_uri(image: Element) -> str:
    init = image.find("init_from")
    if init is None:
        return ""
    reference = init.find("ref")
    return ((init if reference is None else reference).text or "").strip()


def _wrap(sampler: Element | None, tag: str) -> Wrap:
    element = None if sampler is None else sampler.find(f"sampler2D/{tag}")
    return "repeat" if element is None else _WRAPS.get((element.text or "").strip().upper(), "repeat")


def _normal_map(
    effect: Element, uv_index: dict[str, int], document: Document, textures: TextureTable, folder: Path
) -> TextureUse | None:
    """The `bump` texture of an `extra` technique, where the picture holds normals."""
    texture = effect.find(".//bump/texture")
    use = None if texture is None else _texture_use(texture, effect, uv_index, document, textures, folder)
    return use if use is not None and holds_normals(textures.get(use.texture)) else None


def _opacity(
    name: str,
    shader: Element,
    colors: dict[str, tuple[float, ...]],
    floats: dict[str, float],
    document: Document,
) -> float:
    """Opacity by the `opaque` mode of `transparent` (specification: "Determining Transparency"), A_ONE by default.

    A result of exactly 0 is read as 1: an invisible asset is never meant, and exporters that count transparency the
    other way write it for opaque materials.
    """
    element = shader.find("transparent")
    if element is None or "transparent" not in colors:
        return 1.0
    r, g, b, a = (*colors["transparent"], 1.0)[:4]
    transparency = floats.get("transparency", 1.0)
    luminance = 0.212671 * r + 0.715160 * g + 0.072169 * b
    mode = element.get("opaque") or "A_ONE"
    opacity = {
        "A_ZERO": 1.0 - a * transparency,
        "RGB_ZERO": 1.0 - luminance * transparency,
        "RGB_ONE": luminance * transparency,
    }.get(mode, a * transparency)
    opacity = unit_interval(opacity)
    if opacity > 0.0:
        return opacity
    headline = f"material '{name}' would be invisible ({mode}, transparency {transparency:g}); it is read as opaque"
    document.report(
        finding(
            "asset/invalid-material-value", headline, where=document.place(element), value=0.0, severity=Severity.INFO
        )
    )
    return 1.0


def _roughness(
    shader: Element, colors: dict[str, tuple[float, ...]], floats: dict[str, float], *, specular_map: bool
) -> float:
    """From the exponent; a shader without highlight is fully rough."""
    if shader.tag in {"lambert", "constant"}:
        return 1.0
    if not specular_map and not any(colors.get("specular", (1.0,))[:3]):
        return 1.0
    return roughness_from_exponent(floats["shininess"]) if "shininess" in floats else 0.5


def _unmapped(
    shader: Element, colors: dict[str, tuple[float, ...]], floats: dict[str, float], uses: dict[str, TextureUse]
) -> dict[str, Any]:
    unmapped: dict[str, Any] = {"shader": shader.tag}
    unmapped |= {tag: list(c) for tag, c in sorted(colors.items()) if tag not in _MAPPED}
    unmapped |= {tag: value for tag, value in sorted(floats.items()) if tag not in _MAPPED}
    unmapped |= {f"{tag}_texture": use.texture for tag, use in sorted(uses.items()) if tag not in _MAPPED}
    return unmapped
