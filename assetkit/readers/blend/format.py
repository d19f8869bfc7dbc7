"""The format .blend as a row of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from assetkit.readers.source_format import Signature, SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def _read(source: SourceFile) -> Outcome[Model]:
    from assetkit.readers.blend.read import read_blend  # Loads the glTF reader, which discovery does not need.

    return read_blend(source)


FORMAT = SourceFormat(
    "blend", (".blend",), _read, magic=(Signature("Blender data", b"BLENDER"),), referring=(".blend",)
)
