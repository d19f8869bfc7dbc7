"""The source formats that Mana reads, one row each, and the tables that follow from them."""

from __future__ import annotations

from assetkit.readers import stl, usd
from assetkit.readers.collada import format as collada
from assetkit.readers.gltf import format as gltf
from assetkit.readers.obj import format as obj
from assetkit.readers.ply import format as ply
from assetkit.readers.source_format import Reader, SourceFormat

FORMATS: tuple[SourceFormat, ...] = (
    obj.FORMAT,
    gltf.GLB,
    gltf.GLTF,
    stl.FORMAT,
    ply.FORMAT,
    collada.FORMAT,
    usd.USD,
    usd.USDZ,
)
READERS: dict[str, Reader] = {row.name: row.read for row in FORMATS}
MESH_FORMATS: dict[str, str] = {extension: row.name for row in FORMATS for extension in row.extensions}
CAD_FORMATS = frozenset(row.name for row in FORMATS if row.unit_habit == "cad")
