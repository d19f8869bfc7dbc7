"""The format .dae as a row of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from assetkit.readers.source_format import SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def _read(source: SourceFile) -> Outcome[Model]:
    from assetkit.readers.collada.read import read_dae  # Loads lxml and SciPy, which discovery does not need.

    return read_dae(source)


FORMAT = SourceFormat("dae", (".dae",), _read, syntax="XML", referring=(".dae",))
