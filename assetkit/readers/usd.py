"""Reads USD, USDA, USDC and USDZ files into a source model (AOUSD Core Specification 1.0, USDZ specification 1.3)."""

from __future__ import annotations

from assetkit.readers.source_format import Signature, SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def read_usd(source: SourceFile) -> Outcome[Model]:
    """The model in a USD file; see `usdio.read.asset.read_stage` for what is read and for the InvalidInput it
    raises.
    """
    from assetkit.readers.common.images import load_texture  # Loads Pillow,
    from usdio.read.asset import read_stage  # and OpenUSD; discovery needs neither.

    return read_stage(
        source.path, source.root, load_texture=load_texture, visited=source.visited, missing=source.missing
    )


def read_usd_still(source: SourceFile) -> Outcome[Model]:
    """The same without joints: everything that the stage shows as one rigid model, at rest."""
    from assetkit.readers.common.images import load_texture
    from usdio.read.asset import read_stage

    return read_stage(source.path, source.root, load_texture=load_texture, mechanism=False)


USD = SourceFormat(
    "usd",
    (".usd", ".usda", ".usdc"),
    read_usd,
    magic=(
        Signature("USD crate", b"PXR-USDC", (".usd", ".usdc")),
        Signature("USD text", b"#usda", (".usd", ".usda")),
    ),
    referring=(".usd", ".usda"),
)
USDZ = SourceFormat("usdz", (".usdz",), read_usd, magic=(Signature("a ZIP archive", b"PK\x03\x04"),))
