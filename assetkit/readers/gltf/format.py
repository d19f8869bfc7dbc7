"""The formats .glb and .gltf as rows of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from assetkit.readers.source_format import Signature, SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def _read(source: SourceFile) -> Outcome[Model]:
    from assetkit.readers.gltf.read import read_gltf  # Loads SciPy and Draco, which discovery does not need.

    return read_gltf(source)


GLB = SourceFormat("glb", (".glb",), _read, magic=(Signature("binary glTF", b"glTF"),))
GLTF = SourceFormat("gltf", (".gltf",), _read, syntax="JSON", referring=(".gltf",))
