"""The format .ply as a row of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from assetkit.readers.source_format import Signature, SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def _read(source: SourceFile) -> Outcome[Model]:
    from assetkit.readers.ply.read import read_ply  # Loads Pillow, which discovery does not need.

    return read_ply(source)


FORMAT = SourceFormat("ply", (".ply",), _read, magic=(Signature("PLY", b"ply\n"), Signature("PLY", b"ply\r")))
