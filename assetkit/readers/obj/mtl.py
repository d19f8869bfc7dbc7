"""Reads Wavefront MTL material libraries into metallic-roughness materials.

Sources: Wavefront "Advanced Visualizer" appendix B (MTL 4.2) and the PBR extension by Exocortex/Blender
(Pr, Pm, Pc, Pcr, norm).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.common.phong import (
    PHONG_CONFIDENCE,
    bare_metal,
    ior_or_default,
    linear_rgb,
    origins_of,
    roughness_from_exponent,
    unit_interval,
)
from assetkit.readers.common.sniff import as_utf8
from assetkit.readers.common.texture_table import TextureTable, has_alpha, holds_normals
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Anisotropy, Channel, Material, Origin, Sheen, TextureUse
from schemas.diagnostics import Location, Severity, finding

# Options of a texture statement and the least and most arguments each takes.
_OPTIONS: dict[str, tuple[int, int]] = {
    "-blendu": (1, 1),
    "-blendv": (1, 1),
    "-bm": (1, 1),
    "-boost": (1, 1),
    "-cc": (1, 1),
    "-clamp": (1, 1),
    "-imfchan": (1, 1),
    "-mm": (2, 2),
    "-o": (1, 3),
    "-s": (1, 3),
    "-t": (1, 3),
    "-texres": (1, 1),
    "-type": (1, 1),
    "-colorspace": (1, 1),
}
_CHANNELS: dict[str, Channel] = {"r": "r", "g": "g", "b": "b", "m": "a"}
_COLORS = frozenset({"kd", "ks", "ke", "ka", "tf"})
_SCALARS = frozenset({"ns", "ni", "d", "tr", "pr", "pm", "pc", "pcr", "ps", "illum", "sharpness", "aniso", "anisor"})
_MAPS = frozenset({"map_kd", "map_ke", "map_d", "map_pr", "map_pm", "map_bump", "bump", "norm"})
KEYWORDS = _COLORS | _SCALARS | _MAPS
# These have a place in Material.
_FIELDS = frozenset({"kd", "ke", "ns", "ni", "d", "tr", "pr", "pm", "pc", "pcr", "ps", "aniso", "anisor"})


@dataclass(frozen=True)
class Statement:
    """One line of a library: the keyword as written, the text after it, and its place."""

    keyword: str
    text: str
    where: Location


@dataclass
class _Block:
    name: str
    statements: dict[str, Statement] = field(default_factory=dict)


def read_mtl(path: Path, source: SourceFile, textures: TextureTable) -> tuple[tuple[Material, ...], Notes]:
    """The materials of one library in file order; images go to `textures`, sought from the library's folder.

    Colours are taken as display (sRGB) values and become linear: the format leaves it open, and tools show them so.
    A picture in map_Kd replaces Kd (exporters write any Kd beside it); Kd then stays in `unmapped`.
    Unreadable values are dropped with `asset/invalid-material-value`. A name defined twice keeps the first.
    """
    relative = path.resolve().relative_to(source.root.resolve()).as_posix()
    data = as_utf8(path.read_bytes())
    blocks = _blocks(data.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace"), relative)
    materials: dict[str, Material] = {}
    notes = Notes()
    for block in blocks:
        if block.name in materials:
            continue
        material, material_notes = _material(block, path.parent, textures)
        materials[block.name] = material
        notes += material_notes
    return tuple(materials.values()), notes


def _blocks(text: str, file: str) -> list[_Block]:
    blocks: list[_Block] = []
    for number, line in enumerate(text.splitlines(), 1):
        keyword, _, rest = line.strip().replace("\t", " ").partition(" ")
        if not keyword or keyword.startswith("#"):
            continue
        if keyword.lower() == "newmtl":
            blocks.append(_Block(rest.strip()))
        elif blocks:
            where = Location(file=file, line=number, column=len(line) - len(line.lstrip()) + 1)
            blocks[-1].statements[keyword.lower()] = Statement(keyword, rest.strip(), where)
    return blocks


def _material(block: _Block, folder: Path, textures: TextureTable) -> tuple[Material, Notes]:
    values, notes = _values(block)
    maps = {
        key: use
        for key, statement in block.statements.items()
        if key in _MAPS and (use := _texture_use(statement, folder, textures)) is not None
    }
    opacity, opacity_notes = _opacity(values, block)
    bump = next((maps[k] for k in ("norm", "map_bump", "bump") if k in maps and _is_normal(k, maps[k], textures)), None)
    base = maps.get("map_kd")
    mask = maps.get("map_d")
    emissive = values.get("ke", (0.0, 0.0, 0.0))
    taken = {*(_FIELDS & values.keys()), *maps}
    taken -= ({"kd"} if base else set()) | ({"bump", "map_bump"} if bump is None else set())
    taken -= {"d", "tr"} if opacity_notes.diagnostics else set()
    metal = (
        None if base or {"pm", "map_pm"} & block.statements.keys() else bare_metal(values.get("kd"), values.get("ks"))
    )
    taken |= {"ks"} if metal else set()
    diffuse = linear_rgb(values.get("kd", (0.8, 0.8, 0.8)))
    material = Material(
        name=block.name,
        base_color=(1.0, 1.0, 1.0) if base else metal or diffuse,
        base_color_texture=base,
        metallic=unit_interval(values.get("pm", (1.0 if "map_pm" in maps or metal else 0.0,))[0]),
        metallic_texture=_scalar(maps.get("map_pm")),
        roughness=1.0 if "map_pr" in maps else _roughness(values),
        roughness_texture=_scalar(maps.get("map_pr")),
        normal_texture=bump,
        emissive=(1.0, 1.0, 1.0) if "map_ke" in maps and not any(emissive) else linear_rgb(emissive),
        emissive_texture=maps.get("map_ke"),
        opacity=opacity,
        opacity_texture=_mask(mask, textures) if mask else None,
        alpha_mode="blend" if opacity < 1.0 or mask else "opaque",
        ior=ior_or_default(values["ni"][0] if "ni" in values else None),
        clearcoat=unit_interval(values.get("pc", (0.0,))[0]),
        clearcoat_roughness=unit_interval(values.get("pcr", (0.0,))[0]),
        normal_green="undeclared",
        sheen=_sheen(values),
        anisotropy=_anisotropy(values),
        unmapped=_unmapped(block, values, taken),
        lost_textures=("base_color_texture",) if "map_kd" in block.statements and not base else (),
    )
    return replace(material, origins=_origins(material, block, maps, metal=metal is not None)), notes + opacity_notes


def _sheen(values: dict[str, tuple[float, ...]]) -> Sheen | None:
    """White fibres of weight `Ps`."""
    if "ps" not in values:
        return None
    weight = unit_interval(values["ps"][0])
    return Sheen((weight, weight, weight))


def _anisotropy(values: dict[str, tuple[float, ...]]) -> Anisotropy | None:
    """`aniso` in 0..1, turned by `anisor` full turns."""
    if "aniso" not in values:
        return None
    return Anisotropy(unit_interval(values["aniso"][0]), math.tau * values.get("anisor", (0.0,))[0])


# The statements from which each field is made, the first that stands counts.
_STATEMENTS: dict[str, tuple[str, ...]] = {
    "base_color": ("map_kd", "kd"),
    "base_color_texture": ("map_kd",),
    "metallic": ("pm", "map_pm"),
    "metallic_texture": ("map_pm",),
    "roughness": ("map_pr", "pr"),
    "roughness_texture": ("map_pr",),
    "normal_texture": ("norm", "map_bump", "bump"),
    "emissive": ("ke", "map_ke"),
    "emissive_texture": ("map_ke",),
    "opacity": ("d", "tr", "map_d"),
    "opacity_texture": ("map_d",),
    "alpha_mode": ("d", "tr", "map_d"),
    "ior": ("ni",),
    "clearcoat": ("pc",),
    "clearcoat_roughness": ("pcr",),
    "sheen.color": ("ps",),
    "anisotropy.strength": ("aniso",),
    "anisotropy.rotation_rad": ("anisor",),
}


def _origins(material: Material, block: _Block, maps: Mapping[str, TextureUse], *, metal: bool) -> dict[str, Origin]:
    """The statement behind each value, and how sure a conversion is; pictures that are absent are behind none."""
    stated = {key: s.keyword for key, s in block.statements.items() if key not in _MAPS or key in maps}
    origins = origins_of(material, _STATEMENTS, stated, exponent="ns", metal=metal)
    if block.statements.keys() & {"bump", "map_bump"} and "norm" not in block.statements and material.normal_texture:
        origins["normal_texture"] = Origin("inferred", "bump, whose picture holds normals", PHONG_CONFIDENCE)
    return origins


def _values(block: _Block) -> tuple[dict[str, tuple[float, ...]], Notes]:
    """Numbers by lower-case keyword; a colour of one number is grey (MTL 4.2). Unreadable ones are absent."""
    values: dict[str, tuple[float, ...]] = {}
    notes = Notes()
    for key, statement in block.statements.items():
        words = statement.text.split()
        if key not in _COLORS | _SCALARS or (words and words[0] in {"spectral", "xyz"}):
            continue
        if key == "d" and words[:1] == ["-halo"]:
            words = words[1:]
        length = 3 if key in _COLORS else 1
        numbers = _numbers(words[:length])
        if len(words) == 1:
            numbers = numbers * length
        if len(numbers) == length:
            values[key] = numbers
            continue
        diagnostic = finding(
            "asset/invalid-material-value",
            f"material '{block.name}': {statement.keyword} '{statement.text}' is not a number; the default is used",
            where=statement.where,
            value=statement.text,
        )
        notes += repaired(diagnostic, "invalid_material_value", material=block.name, statement=statement.keyword)
    return values, notes


def _numbers(words: list[str]) -> tuple[float, ...]:
    try:
        numbers = tuple(float(w) for w in words)
    except ValueError:
        return ()
    return numbers if all(math.isfinite(n) for n in numbers) else ()


def _opacity(values: dict[str, tuple[float, ...]], block: _Block) -> tuple[float, Notes]:
    """`d`, or 1 - `Tr`. Exactly 0 is read as 1: an invisible asset is never meant, and MeshLab and Cinema 4D write
    `Tr 1` and `d 0` for opaque materials.
    """
    if "d" in values:
        opacity, statement = unit_interval(values["d"][0]), block.statements["d"]
    elif "tr" in values:
        opacity, statement = 1.0 - unit_interval(values["tr"][0]), block.statements["tr"]
    else:
        return 1.0, Notes()
    if opacity > 0.0:
        return opacity, Notes()
    diagnostic = finding(
        "asset/invalid-material-value",
        f"material '{block.name}' would be invisible ({statement.keyword} {statement.text}); it is read as opaque",
        where=statement.where,
        value=0.0,
        severity=Severity.INFO,
    )
    return 1.0, Notes((diagnostic,))


def _roughness(values: dict[str, tuple[float, ...]]) -> float:
    """`Pr`, else from the exponent Ns, else 0.5; a material without highlight (Ks 0, illum 0 or 1) is 1."""
    if "pr" in values:
        return unit_interval(values["pr"][0])
    if not any(values.get("ks", (1.0,))) or values.get("illum", (2.0,))[0] in {0.0, 1.0}:
        return 1.0
    return roughness_from_exponent(values["ns"][0]) if "ns" in values else 0.5


def _texture_use(statement: Statement, folder: Path, textures: TextureTable) -> TextureUse | None:
    """The texture of a map statement with its options; None when there is no such image."""
    options, name = split_options(statement.text)
    if not name:
        return None
    texture = textures.add(name, base=folder, where=statement.where)
    if texture is None:
        return None
    wrap: Literal["repeat", "black"] = "black" if options.get("-clamp", [""])[0].lower() == "on" else "repeat"
    scale = _pair(options.get("-s", []), 1.0)
    offset = _pair(options.get("-o", []), 0.0)
    bias, gain = _pair(options["-mm"], 0.0) if "-mm" in options else (0.0, 1.0)
    channel = _CHANNELS.get(options.get("-imfchan", [""])[0].lower(), "rgb")
    return TextureUse(
        texture, channel, wrap_s=wrap, wrap_t=wrap, uv_scale=scale, uv_offset=offset, scale=gain, bias=bias
    )


def split_options(text: str) -> tuple[dict[str, list[str]], str]:
    """The options of a texture statement with their arguments, and the file name, which may hold spaces."""
    words = text.split(" ")
    options: dict[str, list[str]] = {}
    while words:
        if not words[0]:
            words = words[1:]
            continue
        if words[0].lower() not in _OPTIONS:
            break
        least, most = _OPTIONS[words[0].lower()]
        end = 1 + least
        while end < len(words) - 1 and end < 1 + most and _numbers(words[end : end + 1]):
            end += 1
        options[words[0].lower()] = words[1:end]
        words = words[end:]
    return options, " ".join(words).strip().strip('"')


def _pair(words: list[str], missing: float) -> tuple[float, float]:
    numbers = [*_numbers(words), missing, missing]
    return numbers[0], numbers[1]


def _scalar(use: TextureUse | None) -> TextureUse | None:
    """`use` reading one channel: the red one, unless the statement names another."""
    if use is None or use.channel != "rgb":
        return use
    return replace(use, channel="r")


def _mask(use: TextureUse, textures: TextureTable) -> TextureUse:
    """`use` as an opacity map: its alpha channel where the picture has one, else its brightness (red)."""
    if use.channel != "rgb":
        return use
    return replace(use, channel="a" if has_alpha(textures.get(use.texture)) else "r")


def _is_normal(keyword: str, use: TextureUse, textures: TextureTable) -> bool:
    """`norm` names a normal map by definition; `bump` does when the picture looks like one."""
    return keyword == "norm" or holds_normals(textures.get(use.texture))


def _unmapped(block: _Block, values: dict[str, tuple[float, ...]], taken: set[str]) -> dict[str, Any]:
    """Statements not `taken` by a field of Material, by keyword as written: numbers where they are, else text."""
    unmapped: dict[str, Any] = {}
    for key, statement in block.statements.items():
        if key not in taken:
            numbers = values.get(key, ())
            unmapped[statement.keyword] = list(numbers) if len(numbers) > 1 else (*numbers, statement.text)[0]
    return unmapped
