"""Metadata of a foreign stage: length unit, up axis, default prim, authorship, free texts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, Final, Generic, NamedTuple, TypeVar

from pxr import Sdf, Tf, Usd, UsdGeom

from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.evidence import BY_STANDARD, Evidence, declared, default, inferred
from schemas.model import Axis
from schemas.outcome import INTAKE, Repair
from usdio.read.layer_guard import PinnedLayers
from usdio.read.meshes import IMPLICIT_SHAPES
from usdio.read.shader_graph import to_json

T = TypeVar("T")
FALLBACK_METERS: Final = 0.01  # UsdGeomLinearUnits: a stage without metersPerUnit is in centimetres.
_SURFACES: Final = ("Mesh", *IMPLICIT_SHAPES)
_FALLBACK_AXIS: Final[Axis] = "y"
# our key -> words that name it in customLayerData, assetInfo or SimReady_Metadata, compared without case and marks.
_KEYS: Final = {
    "author": ("author", "authors", "artist", "createdby"),
    "credits": ("credits", "credit", "attribution"),
    "license": ("license", "licence", "licensetype", "spdx"),
    "copyright": ("copyright",),
    "generator": ("creator", "generator", "authoringtool", "exporter"),
    "title": ("title", "name", "assetname"),
    "source": ("source", "sourceurl", "url"),
    "version": ("version",),
}


class MetadataReading(NamedTuple, Generic[T]):
    """A metadata value of the stage, with findings on it and repairs of it."""

    value: T
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def meters_per_unit(stage: Usd.Stage, where: Location) -> MetadataReading[Evidence[float]]:
    """Evidence for the length of one unit in metres; USD's fallback 0.01 with confidence 0.5 when none is authored.

    A value of another type than double is used and repaired. Raises InvalidInput `asset/invalid-unit-value` when it is
    no positive finite number.
    """
    key = UsdGeom.Tokens.metersPerUnit
    if not stage.HasAuthoredMetadata(key):
        return MetadataReading(
            declared(FALLBACK_METERS, "USD fallback, metersPerUnit is not authored", confidence=BY_STANDARD)
        )
    authored = _raw(stage, key)
    try:
        value = float(authored)
    except (TypeError, ValueError):
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        headline = f"metersPerUnit is {authored}, which is no length"
        raise InvalidInput(
            finding("asset/invalid-unit-value", headline, where=where, value=str(authored), bound=0.0, unit="m")
        )
    try:
        return MetadataReading(declared(float(UsdGeom.GetStageMetersPerUnit(stage)), "metersPerUnit"))
    except Tf.ErrorException:
        note = finding(
            "asset/invalid-unit-value",
            f"metersPerUnit is stored with the wrong type; its value {value:g} was used",
            where=where,
            value=value,
            unit="m",
            severity=Severity.WARNING,
        )
        return _repaired(declared(value, "metersPerUnit, wrong value type", confidence=0.9), note, value)


def up_axis(stage: Usd.Stage, where: Location) -> MetadataReading[Evidence[Axis]]:
    """Evidence for the up axis: Y or Z as declared; X or another spelling inferred and repaired; USD's Y if absent."""
    key = UsdGeom.Tokens.upAxis
    if not stage.HasAuthoredMetadata(key):
        return MetadataReading(declared(_FALLBACK_AXIS, "USD fallback, upAxis is not authored", confidence=BY_STANDARD))
    authored = str(_raw(stage, key))
    if authored in (UsdGeom.Tokens.y, UsdGeom.Tokens.z):
        return MetadataReading(declared(_axis(authored) or _FALLBACK_AXIS, "upAxis"))
    axis = _axis(authored)
    read_as = axis or _FALLBACK_AXIS
    headline = f"upAxis '{authored}' is not allowed by USD; the file was read {read_as}-up"
    note = finding("asset/invalid-up-axis", headline, where=where, value=authored, bound="Y or Z")
    if axis is None:
        return _repaired(default(_FALLBACK_AXIS, f"upAxis '{authored}' names no axis"), note, authored)
    return _repaired(inferred(axis, "upAxis outside USD's rules", 0.8), note, authored)


def start_prim(stage: Usd.Stage, where: Location) -> MetadataReading[Usd.Prim]:
    """The default prim, or the pseudo-root when there is none; a default prim that does not exist is repaired."""
    layer = stage.GetRootLayer()
    if not layer.HasDefaultPrim():
        return MetadataReading(stage.GetPseudoRoot())
    prim = stage.GetDefaultPrim()
    if prim:
        return MetadataReading(prim)
    headline = f"defaultPrim '{layer.defaultPrim}' does not exist; the whole stage was read"
    note = finding("asset/invalid-default-prim", headline, where=where, value=layer.defaultPrim)
    return _repaired(stage.GetPseudoRoot(), note, layer.defaultPrim)


def hints(stage: Usd.Stage, start: Usd.Prim) -> tuple[str, ...]:
    """Documentation, comments and free custom texts of the root layer and the start prim, verbatim."""
    layer = stage.GetRootLayer()
    texts = [layer.documentation, layer.comment]
    texts += [str(start.GetMetadata(key) or "") for key in ("documentation", "comment")]
    texts += [f"{key}: {value}" for key, value in _texts(dict(layer.customLayerData))]
    return tuple(dict.fromkeys(text for text in texts if text))


def layer_contradictions(layers: PinnedLayers, where: Location) -> tuple[Diagnostic, ...]:
    """Warnings about layers that hold geometry and state another unit or up axis than the root layer.

    Composition converts neither; the root layer's value holds (UsdGeomLinearUnits). None where an
    `xformOp` resolves the difference (`unitsResolve`).
    """
    diagnostics: list[Diagnostic] = []
    root = layers.root.pseudoRoot
    for layer in layers.copies if len(layers.copies) > 1 else ():
        paths: list[Sdf.Path] = []
        layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
        if any(path.name.endswith(":unitsResolve") for path in paths):
            return ()
        specs = (layer.GetPrimAtPath(path) for path in paths if path.IsPrimPath())
        if layer == layers.root or not any(spec and spec.typeName in _SURFACES for spec in specs):
            continue
        name = layers.location_of(layer).name
        for key in (UsdGeom.Tokens.metersPerUnit, UsdGeom.Tokens.upAxis):
            authored = layer.pseudoRoot.GetInfo(key) if layer.pseudoRoot.HasInfo(key) else None
            if authored is not None and authored != root.GetInfo(key):
                headline = f"layer {name} states {key} {authored}, the stage {root.GetInfo(key)}; the stage's was used"
                diagnostics.append(finding("asset/contradictory-evidence", headline, where=where, value=str(authored)))
    return tuple(sorted(diagnostics, key=lambda d: d.headline))


def metadata(stage: Usd.Stage, start: Usd.Prim) -> dict[str, str]:
    """Author, license, copyright, generator, title, source and version as far as the file states them."""
    layer = stage.GetRootLayer()
    pairs = list(_texts(dict(layer.customLayerData)))
    for prim in (start, *start.GetChildren()) if start.IsPseudoRoot() else (start,):
        pairs += _texts(dict(prim.GetAssetInfo()))
        pairs += _texts(dict(prim.GetCustomData()))
    texts_by_key: dict[str, list[str]] = {}
    for path, value in pairs:
        for part in path.split(":"):
            word = re.sub(r"[^a-z]", "", part.lower())
            key = next((key for key, words in _KEYS.items() if word in words), None)
            if key is not None:
                texts_by_key.setdefault(key, []).append(value)
                break
    if "generator" not in texts_by_key and (
        match := re.match(r"\s*(blender v[\d.]+)", layer.documentation, re.IGNORECASE)
    ):
        texts_by_key["generator"] = [match[1]]
    return {key: "; ".join(dict.fromkeys(texts_by_key[key])) for key in sorted(texts_by_key)}


def _raw(stage: Usd.Stage, key: str) -> Any:
    """Stage metadata as authored, whatever its type; the session layer is ours and empty."""
    return stage.GetRootLayer().pseudoRoot.GetInfo(key)


def _axis(text: str) -> Axis | None:
    axes: dict[str, Axis] = {"x": "x", "y": "y", "z": "z"}
    return axes.get(text.strip().lower().lstrip("+"))


def _texts(tree: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Key paths and non-empty texts of a nested dictionary, in key order."""
    for key in sorted(tree):
        value = tree[key]
        if isinstance(value, dict):
            yield from _texts(value, f"{prefix}{key}:")
        elif isinstance(value, str) and value:
            yield f"{prefix}{key}", value
        elif isinstance(value, Sdf.AssetPath | bool | int | float):
            continue
        elif value:
            yield f"{prefix}{key}", ", ".join(str(v) for v in to_json(value))


def _repaired(value: T, note: Diagnostic, authored: float | str) -> MetadataReading[T]:
    name = note.code.removeprefix("asset/").replace("-", "_")
    repair = Repair(name=name, code=note.code, stage=INTAKE, before={"authored": authored})
    return MetadataReading(value, (note,), (repair,))
