"""Converts a MaterialX document into a USD layer, since the OpenUSD wheels ship without their MaterialX plugin.

The layer follows the layout of OpenUSD's usdMtlx plugin: materials under /MaterialX/Materials, their shaders below
them (here with the node graphs each of them needs), shader ids `ND_<category>_<type>` (MaterialX 1.38 specification).
"""

from __future__ import annotations

from typing import Final

from lxml import etree
from pxr import Sdf, Tf, Usd, UsdShade

from schemas.diagnostics import InvalidInput, finding
from usdio.read.asset_location import AssetLocation

MAX_MATERIALX_DEPTH: Final = 16
_INCLUDE: Final = "{http://www.w3.org/2001/XInclude}include"
_TYPES: Final = {
    "float": Sdf.ValueTypeNames.Float,
    "integer": Sdf.ValueTypeNames.Int,
    "boolean": Sdf.ValueTypeNames.Bool,
    "color3": Sdf.ValueTypeNames.Color3f,
    "color4": Sdf.ValueTypeNames.Color4f,
    "vector2": Sdf.ValueTypeNames.Float2,
    "vector3": Sdf.ValueTypeNames.Float3,
    "vector4": Sdf.ValueTypeNames.Float4,
    "filename": Sdf.ValueTypeNames.Asset,
}


def material_x_layer(location: AssetLocation) -> Sdf.Layer:
    """An anonymous layer with the document's materials; asset paths stay relative to the document.

    Raises InvalidInput `asset/parse-error` for broken XML, `asset/cyclic-reference` for inclusions without end, and
    whatever `AssetLocation.resolve` raises for an include that escapes. No entity or DTD is ever loaded.
    """
    document = _document(location, 0)
    layer = Sdf.Layer.CreateAnonymous(f"{location.name}.usda")
    stage = Usd.Stage.Open(layer)
    scope = stage.DefinePrim("/MaterialX", "Scope")
    stage.SetDefaultPrim(scope)
    materials = stage.DefinePrim("/MaterialX/Materials", "Scope").GetPath()
    for element in document.findall("surfacematerial"):
        path = materials.AppendChild(_identifier(element))
        material = UsdShade.Material.Define(stage, path)
        for port in element.findall("input"):
            source = _source(stage, document, document, path, port, 0)
            if port.get("name") == "surfaceshader" and source is not None:
                material.CreateSurfaceOutput("mtlx").ConnectToSource(source)
    return layer


def _document(location: AssetLocation, depth: int) -> etree._Element:
    if depth > MAX_MATERIALX_DEPTH:
        raise InvalidInput(
            finding("asset/cyclic-reference", "MaterialX files include each other without end", where=location.where())
        )
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True)
    try:
        document = etree.fromstring(location.read(), parser)
    except etree.XMLSyntaxError as error:
        where = location.where(line=error.lineno)
        raise InvalidInput(
            finding("asset/parse-error", f"not a MaterialX document: {error.msg}", where=where)
        ) from error
    for include in document.findall(_INCLUDE):
        target = location.resolve(include.get("href", ""))
        if target is not None:
            document.extend(list(_document(target, depth + 1)))
    return document


def _source(
    stage: Usd.Stage,
    document: etree._Element,
    scope: etree._Element,
    path: Sdf.Path,
    port: etree._Element,
    depth: int,
) -> UsdShade.Output | None:
    """The output that feeds `port`, its node authored below `path` on first use; None when nothing does."""
    output = _identifier_text(port.get("output", "out"))
    if port.get("nodegraph"):
        graph = _named(document, port.get("nodegraph", ""))
        if graph is None:
            return None
        inside = path.AppendChild(_identifier(graph))
        stage.DefinePrim(inside, "NodeGraph")
        ports = graph.findall("output")
        chosen = next((o for o in ports if o.get("name") == port.get("output")), ports[0] if ports else None)
        return None if chosen is None else _source(stage, document, graph, inside, chosen, depth + 1)
    node = _named(scope, port.get("nodename", ""))
    if node is None or depth > MAX_MATERIALX_DEPTH:
        return None
    inside = path.AppendChild(_identifier(node))
    shader = UsdShade.Shader.Get(stage, inside)
    if not shader:
        shader = UsdShade.Shader.Define(stage, inside)
        shader.CreateIdAttr(f"ND_{node.tag}_{node.get('type', '')}")
        for child in node.findall("input"):
            _author_input(stage, document, scope, path, shader, child, depth)
    return shader.CreateOutput(output, Sdf.ValueTypeNames.Token)


def _author_input(
    stage: Usd.Stage,
    document: etree._Element,
    scope: etree._Element,
    path: Sdf.Path,
    shader: UsdShade.Shader,
    element: etree._Element,
    depth: int,
) -> None:
    type_name = _TYPES.get(element.get("type", ""), Sdf.ValueTypeNames.String)
    port = shader.CreateInput(_identifier(element), type_name)
    if element.get("interfacename"):
        element = _named(scope, element.get("interfacename", "")) or element
    value = _value(element, scope)
    if value is not None:
        port.Set(value)
        return
    source = _source(stage, document, scope, path, element, depth + 1)
    if source is not None:
        port.ConnectToSource(source)


def _value(element: etree._Element, scope: etree._Element):
    """The literal value of an input in its USD type, or None when absent or unreadable."""
    text = element.get("value")
    if text is None:
        return None
    kind = element.get("type", "")
    if kind == "filename":
        return Sdf.AssetPath(f"{scope.get('fileprefix', '')}{text}") if text else None
    try:
        if kind == "boolean":
            return text.strip().lower() == "true"
        if kind == "integer":
            return int(text)
        if kind == "float":
            return float(text)
        if kind in _TYPES:
            return tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    return text


def _named(scope: etree._Element, name: str) -> etree._Element | None:
    return next((child for child in scope if child.get("name") == name), None)


def _identifier(element: etree._Element) -> str:
    return _identifier_text(element.get("name", "unnamed"))


def _identifier_text(text: str) -> str:
    return Tf.MakeValidIdentifier(text)
