"""Opens the layers of a USD asset one by one, before composition, checks them and pins every reference.

Each layer is opened as a private, anonymous copy, and every sublayer, reference and payload is rewritten to the copy
of the file it names. OpenUSD's own resolver, which would search the working directory and any absolute path, is thus
never used, and reading the same asset twice in one process cannot meet a stale layer.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, Final, Literal

from pxr import Sdf, Tf, Usd

from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from usdio.read.asset_location import AssetLocation, locate_asset
from usdio.read.materialx import material_x_layer
from usdio.read.text_nesting import require_shallow

MAX_LAYERS: Final = 4096
_FORMATS: Final = ("usd", "usda", "usdc")
_POSITION: Final = re.compile(r":(\d+):(\d+): (.*)", re.DOTALL)
_LFS_POINTER: Final = b"version https://git-lfs"
_HTML: Final = re.compile(rb"\s*<(!doctype\s+html|html|head|body)\b", re.IGNORECASE)
_CRATE: Final = b"PXR-USDC"


@dataclass(frozen=True)
class PinnedLayers:
    """The private copies of an asset's layers.

    `locations` maps a copy's identifier to the file it came from; `absent` maps the placeholder identifier of a file
    that does not exist, or is not USD, to the finding to report if composition needs it. `clips` lists files whose
    value clips were dropped. `copies` keeps the layers alive.
    """

    root: Sdf.Layer
    locations: dict[str, AssetLocation]
    absent: dict[str, Diagnostic]
    clips: tuple[AssetLocation, ...]
    copies: tuple[Sdf.Layer, ...] = field(repr=False)

    def location_of(self, layer: Sdf.Layer) -> AssetLocation:
        """The file a layer came from; the root file for layers made in memory (the session layer)."""
        return self.locations.get(layer.identifier, self.locations[self.root.identifier])


@dataclass(frozen=True)
class _Arc:
    """One authored dependency: `uri` is empty for a reference within the layer."""

    kind: Literal["sublayer", "reference"]
    uri: str
    prim: Sdf.Path
    target: Sdf.Path


def check_layers(path: Path, root: Path) -> PinnedLayers:
    """The asset's layers, reachable through any variant, checked and pinned to files below `root`.

    Raises InvalidInput: `asset/path-escape`, `asset/remote-reference`, `asset/cyclic-reference` (layers that sublayer
    each other, a prim that refers to itself or an ancestor), `asset/parse-error`, `asset/truncated`,
    `asset/wrong-content`, `asset/lfs-pointer`, `asset/resource-limit`. A missing layer is no error here.
    """
    start = locate_asset(path, root)
    layers: dict[AssetLocation, Sdf.Layer] = {}
    targets: dict[AssetLocation, dict[str, AssetLocation | None]] = {}
    sublayers: dict[AssetLocation, set[AssetLocation]] = {}
    clips: list[AssetLocation] = []
    pending = [start]
    variables: dict[str, Any] = {}
    while pending:
        location = pending.pop()
        if location in layers:
            continue
        if len(layers) >= MAX_LAYERS:
            raise InvalidInput(
                finding("asset/resource-limit", "the asset has too many layers", value=len(layers), bound=MAX_LAYERS)
            )
        layer = layers[location] = _open(location)
        variables = variables or dict(layer.expressionVariables)
        targets[location] = {}
        specs = _specs(layer)
        for arc in _arcs(layer, specs):
            target = _follow(arc, location, layer, variables)
            if arc.uri:
                targets[location][arc.uri] = target
            if target == location or not arc.uri:
                _check_ancestor(arc, location, layer)
            elif target is not None and target.extension in (*_FORMATS, "mtlx"):
                pending.append(target)
                if arc.kind == "sublayer":
                    sublayers.setdefault(location, set()).add(target)
        _check_assets(layer, location, specs)
        if _drop_clips(specs):
            clips.append(location)
    _check_sublayer_cycle(sublayers)
    absent = _pin(layers, targets)
    locations = {layer.identifier: location for location, layer in layers.items()}
    return PinnedLayers(layers[start], locations, absent, tuple(clips), tuple(layers.values()))


def _open(location: AssetLocation) -> Sdf.Layer:
    """A private copy of one layer file. Raises InvalidInput when it is not readable USD (or MaterialX)."""
    where = location.where()
    head = location.read(4096)
    if not head.strip():
        raise InvalidInput(finding("asset/truncated", "the file is empty", where=where, value=len(head), unit="bytes"))
    if head.lstrip().startswith(_LFS_POINTER):
        raise InvalidInput(finding("asset/lfs-pointer", "git-LFS pointer text stands in for the layer", where=where))
    if location.extension == "mtlx":
        return material_x_layer(location)
    if location.extension not in _FORMATS or _HTML.match(head) or not _looks_like_usd(head, location.extension):
        headline = (
            f"the file is named .{location.extension} but holds {'an HTML page' if _HTML.match(head) else 'no USD'}"
        )
        raise InvalidInput(finding("asset/wrong-content", headline, where=where))
    data = location.read()
    # Bytes 16..24 of a crate file are the offset of its table of contents (OpenUSD, crateFile.h, _BootStrap).
    if head.startswith(_CRATE) and not 0 < int.from_bytes(data[16:24], "little") < len(data):
        raise InvalidInput(finding("asset/truncated", "the table of contents lies behind the end", where=where))
    if not head.startswith(_CRATE):
        require_shallow(data, where)
    try:
        layer = Sdf.Layer.OpenAsAnonymous(location.identifier)
    except Tf.ErrorException as error:
        raise InvalidInput(_parse_error(error, location, data)) from error
    if layer is None:
        raise InvalidInput(finding("asset/parse-error", "OpenUSD cannot read the layer", where=where))
    return layer


def _looks_like_usd(head: bytes, extension: str) -> bool:
    text, crate = head.startswith((b"#usda", b"#sdf", b"\xef\xbb\xbf#usda")), head.startswith(_CRATE)
    return (text and extension != "usdc") or (crate and extension != "usda")


def _parse_error(error: Tf.ErrorException, location: AssetLocation, data: bytes) -> Diagnostic:
    """`asset/parse-error` with the position OpenUSD reports; `asset/truncated` when that is the end of the text."""
    text = message(error)
    match = _POSITION.search(text)
    if match is None:
        code = "asset/truncated" if data.startswith(_CRATE) else "asset/parse-error"
        return finding(code, "OpenUSD cannot read the layer", where=location.where(), value=_reason(text, location))
    line, column = int(match[1]), int(match[2])
    where = location.where(line=line, column=column)
    if line >= len(data.rstrip().splitlines()) and not data.rstrip().endswith(b"}"):
        return finding("asset/truncated", "the text ends inside a prim or value", where=where)
    return finding("asset/parse-error", "the layer has a syntax error", where=where, value=_reason(match[3], location))


def message(error: Tf.ErrorException) -> str:
    """OpenUSD's last message. It quotes the file, whose bytes need not be UTF-8."""
    try:
        return str(error.args[-1] if error.args else error)
    except UnicodeDecodeError as undecodable:
        return undecodable.object.decode(errors="replace")


def _reason(text: str, location: AssetLocation) -> str:
    """OpenUSD's message without its C++ names and without the folder the asset lies in."""
    text = text.replace(f"{location.root}/", "")
    text = re.sub(r"Error in '.*?' at line \d+ in file \S+ : ", "", text)
    text = re.sub(r"\s*parse error matching \S+?::(\w+)", r"expected \1", text)
    return " ".join(text.split()).strip("' \"")[:300]


def _arcs(layer: Sdf.Layer, specs: list[Sdf.Spec]) -> Iterator[_Arc]:
    """Every sublayer, reference and payload authored in the layer, in any variant."""
    top = Sdf.Path.absoluteRootPath
    for uri in layer.subLayerPaths:
        yield _Arc("sublayer", uri, top, top)
    for prim in _prims(specs):
        path = prim.path.StripAllVariantSelections()
        for arcs in (prim.referenceList, prim.payloadList):
            for item in arcs.GetAddedOrExplicitItems():
                yield _Arc("reference", item.assetPath, path, item.primPath)


def _specs(layer: Sdf.Layer) -> list[Sdf.Spec]:
    """All specs of a layer, in path order, including those inside variants."""
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    return [spec for path in sorted(paths) if (spec := layer.GetObjectAtPath(path)) is not None]


def _prims(specs: list[Sdf.Spec]) -> Iterator[Sdf.PrimSpec]:
    for spec in specs:
        if isinstance(spec, Sdf.VariantSpec):
            yield spec.primSpec
        elif isinstance(spec, Sdf.PrimSpec) and not spec.path.IsAbsoluteRootPath():
            yield spec


def _follow(arc: _Arc, location: AssetLocation, layer: Sdf.Layer, variables: dict[str, Any]) -> AssetLocation | None:
    uri = _evaluate(arc.uri, {**dict(layer.expressionVariables), **variables})
    file, _ = Sdf.Layer.SplitIdentifier(uri) if uri else ("", {})
    return location.resolve(file, prim=str(arc.prim)) if file else None


def _evaluate(uri: str, variables: dict[str, Any]) -> str:
    """`uri` with a variable expression replaced by its value; "" when it has none."""
    if not Sdf.VariableExpression.IsExpression(uri):
        return uri
    value = Sdf.VariableExpression(uri).Evaluate(variables).value
    return value if isinstance(value, str) else ""


def _check_ancestor(arc: _Arc, location: AssetLocation, layer: Sdf.Layer) -> None:
    target = arc.target
    if target.isEmpty and layer.HasDefaultPrim():
        target = layer.GetDefaultPrimAsPath()
    if arc.kind == "sublayer" or (not target.isEmpty and arc.prim.HasPrefix(target)):
        raise InvalidInput(
            finding(
                "asset/cyclic-reference",
                f"{arc.prim if arc.kind == 'reference' else 'the layer'} contains itself",
                where=location.where(prim=str(arc.prim)),
                value=str(target) if arc.kind == "reference" else arc.uri,
            )
        )


def _check_sublayer_cycle(sublayers: dict[AssetLocation, set[AssetLocation]]) -> None:
    try:
        TopologicalSorter(sublayers).prepare()
    except CycleError as error:
        cycle: list[AssetLocation] = error.args[1]
        names = " > ".join(location.name for location in cycle)
        raise InvalidInput(
            finding("asset/cyclic-reference", "layers contain each other", where=cycle[0].where(), value=names)
        ) from error


def _check_assets(layer: Sdf.Layer, location: AssetLocation, specs: list[Sdf.Spec]) -> None:
    """Raise for asset-valued attributes and metadata (textures, clips) that name something outside the root."""
    for spec in specs:
        where = str(spec.path)
        if isinstance(spec, Sdf.AttributeSpec):
            if spec.GetInfo("typeName") not in ("asset", "asset[]"):  # the name; a damaged type crashes OpenUSD
                continue
            times = layer.ListTimeSamplesForPath(spec.path)
            values = [spec.default, *(layer.QueryTimeSample(spec.path, t) for t in times)]
        elif isinstance(spec, Sdf.PrimSpec):
            values = [spec.GetInfo(Usd.Tokens.clips)] if spec.HasInfo(Usd.Tokens.clips) else []
        else:
            continue
        for asset in _asset_paths(values):
            location.resolve(_evaluate(asset, dict(layer.expressionVariables)), prim=where)


def _asset_paths(value: Any) -> Iterator[str]:
    """Every non-empty asset path inside nested lists and dictionaries."""
    if isinstance(value, Sdf.AssetPath):
        if value.path:
            yield value.path
    elif isinstance(value, dict):
        for key in sorted(value):
            yield from _asset_paths(value[key])
    elif isinstance(value, list | tuple | Sdf.AssetPathArray):
        for item in value:
            yield from _asset_paths(item)


def _pin(
    layers: dict[AssetLocation, Sdf.Layer], targets: dict[AssetLocation, dict[str, AssetLocation | None]]
) -> dict[str, Diagnostic]:
    """Rewrite all dependencies to the private copies; findings on absent files by placeholder identifier."""
    absent: dict[str, Diagnostic] = {}
    for location, layer in layers.items():
        for uri in filter(None, layer.GetCompositionAssetDependencies()):  # "" is a reference within the layer
            target = targets[location].get(uri)
            if target in layers:
                _redirect(layer, location, uri, layers[target].identifier)
                continue
            placeholder = f"anon:0x0:absent-{len(absent)}.usda"
            _redirect(layer, location, uri, placeholder)
            why = "is not there" if target is None else "is not a USD or MaterialX layer"
            absent[placeholder] = finding(
                "asset/missing-dependency",
                f"layer '{uri}' {why}; it was left out",
                where=location.where(),
                value=uri,
                severity=Severity.WARNING,
            )
    return absent


def _redirect(layer: Sdf.Layer, location: AssetLocation, uri: str, identifier: str) -> None:
    """Replace `uri` by `identifier` in every arc of `layer`.

    OpenUSD stops at the sublayers when one of them matches and leaves references to the same file as they are, so the
    call is repeated; what then still names the file must not be composed. Raises InvalidInput `asset/schema-error`.
    """
    for _ in range(3):
        layer.UpdateCompositionAssetDependency(uri, identifier)
    if uri in layer.GetCompositionAssetDependencies():
        headline = f"the reference to '{uri}' cannot be pinned to a file"
        raise InvalidInput(finding("asset/schema-error", headline, where=location.where(), value=uri))


def _drop_clips(specs: list[Sdf.Spec]) -> bool:
    """Remove value clips, whose files OpenUSD would open by itself; True when there were any."""
    prims = [prim for prim in _prims(specs) if prim.HasInfo(Usd.Tokens.clips)]
    for prim in prims:
        prim.ClearInfo(Usd.Tokens.clips)
    return bool(prims)
