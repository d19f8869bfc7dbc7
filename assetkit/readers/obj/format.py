"""The format .obj as a row of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from assetkit.readers.source_format import SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def _read(source: SourceFile) -> Outcome[Model]:
    from assetkit.readers.obj.read import read_obj  # Loads Pillow, which discovery does not need.

    return read_obj(source)


FORMAT = SourceFormat("obj", (".obj",), _read)
