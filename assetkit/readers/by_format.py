"""The reader of each source format, by the name of the format."""

from __future__ import annotations

from collections.abc import Callable

from assetkit.readers.collada.read import read_dae
from assetkit.readers.gltf.read import read_gltf
from assetkit.readers.obj.read import read_obj
from assetkit.readers.ply.read import read_ply
from assetkit.readers.stl import read_stl
from assetkit.readers.usd import read_usd
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome

READERS: dict[str, Callable[[SourceFile], Outcome[Model]]] = {
    "obj": read_obj,
    "glb": read_gltf,
    "gltf": read_gltf,
    "stl": read_stl,
    "ply": read_ply,
    "dae": read_dae,
    "usd": read_usd,
    "usdz": read_usd,
}
