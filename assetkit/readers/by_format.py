"""The source formats that Mana reads, one row each, and the tables that follow from them."""

from __future__ import annotations

from assetkit.readers import stl, usd
from assetkit.readers.blend import format as blend
from assetkit.readers.collada import format as collada
from assetkit.readers.gltf import format as gltf
from assetkit.readers.obj import format as obj
from assetkit.readers.ply import format as ply
from assetkit.readers.robot.format import description_formats
from assetkit.readers.source_format import Reader, SourceFormat

MESH_FILES: tuple[SourceFormat, ...] = (
    obj.FORMAT,
    gltf.GLB,
    gltf.GLTF,
    stl.FORMAT,
    ply.FORMAT,
    collada.FORMAT,
    usd.USD,
    usd.USDZ,
    blend.FORMAT,
)
# Descriptions of links and joints name mesh files, which the readers of these read.
FORMATS = (*MESH_FILES, *description_formats({e: row.read for row in MESH_FILES for e in row.extensions}))
READERS: dict[str, Reader] = {row.name: row.read for row in FORMATS}
FORMAT_OF: dict[str, str] = {extension: row.name for row in FORMATS for extension in row.extensions}
CAD_FORMATS = frozenset(row.name for row in FORMATS if row.unit_habit == "cad")
