"""USD, USDA, USDC and USDZ files (AOUSD Core Specification 1.0, USDZ specification 1.3)."""

from __future__ import annotations

from assetkit.readers.images import load_texture
from assetkit.source import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome
from usdio.read import read_stage


def read_usd(source: SourceFile) -> Outcome[Model]:
    """The model in a USD file; see `usdio.read.read_stage` for what is read and for the InvalidInput it raises."""
    return read_stage(
        source.path, source.root, load_texture=load_texture, visited=source.visited, missing=source.missing
    )
