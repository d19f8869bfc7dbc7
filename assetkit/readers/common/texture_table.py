"""Collects the textures of one model while it is read: each image is loaded once; lost ones are reported."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from assetkit.readers.common.images import load_texture
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Texture
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.files.references import tile_references
from schemas.outcome import INTAKE, Repair


class TextureTable:
    """Reads each referenced image once and collects what was found on the way.

    A missing or unreadable image is dropped with a warning and one repair per file; the material keeps its scalar.
    """

    def __init__(self, source: SourceFile) -> None:
        self._source = source
        self._by_reference: dict[tuple[Path, str], str | None] = {}
        self._by_path: dict[Path, str | None] = {}
        self.textures: list[Texture] = []
        self.diagnostics: list[Diagnostic] = []
        self.repairs: list[Repair] = []

    def add(self, uri: str, *, base: Path, where: Location) -> str | None:
        """The name of the texture `uri` refers to, seen from folder `base`; None when it cannot be had.

        Raises InvalidInput as `SourceFile.resolve` does when the reference leaves the asset's root or the machine,
        and as `load_texture` does for images too large to decode.
        """
        key = (base, uri)
        if key not in self._by_reference:
            self._by_reference[key] = self._load(uri, base, where)
        return self._by_reference[key]

    def get(self, name: str) -> Texture:
        """The texture called `name`."""
        return next(t for t in self.textures if t.name == name)

    def missing(self, uri: str, where: Location) -> None:
        """Note that the image called `uri` is absent."""
        self._drop(uri, finding("asset/missing-texture", f"texture '{uri}' is absent", where=where, value=uri))

    def _load(self, uri: str, base: Path, where: Location) -> str | None:
        resolved = (self._source.resolve(u, where=where, base=base) for u in tile_references(uri))
        tiles = [path for path in resolved if path is not None]
        if not tiles:
            self.missing(uri, where)
            return None
        path = tiles[0]
        if len(tiles) > 1:
            headline = f"'{uri}' has {len(tiles)} tiles; all of the surface shows {path.name}"
            self._drop(uri, finding("asset/unsupported-texture", headline, where=where, value=uri))
        if path not in self._by_path:
            texture, diagnostics = load_texture(path.read_bytes(), self._free_name(path.stem), where=where)
            for diagnostic in diagnostics:
                self._drop(uri, diagnostic)
            if texture is not None:
                self.textures.append(texture)
            self._by_path[path] = texture.name if texture else None
        return self._by_path[path]

    def _drop(self, uri: str, diagnostic: Diagnostic) -> None:
        name = diagnostic.code.removeprefix("asset/").replace("-", "_")
        self.diagnostics.append(diagnostic)
        self.repairs.append(Repair(name=name, code=diagnostic.code, stage=INTAKE, before={"texture": uri}))

    def _free_name(self, stem: str) -> str:
        taken = {t.name for t in self.textures}
        stem = stem or "texture"
        return next(name for name in (stem, *(f"{stem}_{i}" for i in range(2, len(taken) + 3))) if name not in taken)


def holds_normals(texture: Texture) -> bool:
    """Whether a picture named as a bump map holds tangent-space normals, as many exporters write it: on average it is
    then the blue (0.5, 0.5, 1) of an even surface. Otherwise it holds heights, which Material has no field for.
    """
    mean = np.asarray(picture(texture).convert("RGB").resize((16, 16))).mean(axis=(0, 1)) / 255.0
    return bool(np.all(np.abs(mean - [0.5, 0.5, 1.0]) < 0.15))


def has_alpha(texture: Texture) -> bool:
    """Whether a picture has an alpha channel of its own."""
    return "A" in picture(texture).getbands()


def picture(texture: Texture) -> Image.Image:
    """The decoded picture. `load_texture` has decoded it once, so it is known to be sound and small enough."""
    return Image.open(io.BytesIO(texture.data), formats=("PNG", "JPEG"))
