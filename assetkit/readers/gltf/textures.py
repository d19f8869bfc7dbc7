"""Loads the textures of a glTF document: the image that a material samples, and how (glTF 2.0, section 3.8)."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Final, Literal
from urllib.parse import unquote

from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.common.images import load_texture
from assetkit.readers.gltf.buffers import Buffers, read_uri
from assetkit.readers.gltf.json import Json
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Channel, Texture, TextureUse
from schemas.diagnostics import Diagnostic, finding

Wrap = Literal["repeat", "clamp", "mirror"]
_WRAP: Final[dict[int, Wrap]] = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
# Tried in this order: the plain image first, because its bytes can be kept as they are.
_SOURCES: Final = ("EXT_texture_webp", "KHR_texture_basisu")


class Textures:
    """Loads each image that a material in use names, once; collects the textures and findings."""

    def __init__(self, source: SourceFile, document: Json, buffers: Buffers) -> None:
        self._source = source
        self._buffers = buffers
        self._textures = document.items("textures")
        self._images = document.items("images")
        self._samplers = document.items("samplers")
        self._by_texture: dict[int, Texture | None] = {}
        self._by_image: dict[int, tuple[Texture | None, tuple[Diagnostic, ...]]] = {}
        self._by_content: dict[bytes, Texture] = {}
        self.loaded: list[Texture] = []
        self.notes = Notes()

    def use(
        self, info: Json | None, channel: Channel = "rgb", *, scale: float = 1.0, bias: float = 0.0
    ) -> tuple[TextureUse, Texture] | None:
        """How `info` (a textureInfo object) samples its texture, and that texture; None when it cannot be had.

        A lost picture is noted: `asset/missing-texture`, `asset/corrupt-texture` or `asset/unsupported-texture`.
        Raises InvalidInput for wrong types, paths that leave the root, network addresses and images too large.
        """
        if info is None:
            return None
        index = info.require("index").as_index(self._textures, "textures")
        if index not in self._by_texture:
            self._by_texture[index] = self._load(self._textures[index])
        texture = self._by_texture[index]
        if texture is None:
            return None
        sampler = self._textures[index].index("sampler", self._samplers, "samplers")
        transform = info.extension("KHR_texture_transform")
        uv_set = info.integer("texCoord", 0)
        uv_scale, uv_rotation_rad, uv_offset = (1.0, 1.0), 0.0, (0.0, 0.0)
        if transform is not None:
            uv_set = transform.integer("texCoord", uv_set)
            uv_scale, uv_rotation_rad, uv_offset = usd_transform(
                _pair(transform, "scale", (1.0, 1.0)),
                transform.number("rotation", 0.0),
                _pair(transform, "offset", (0.0, 0.0)),
            )
        use = TextureUse(
            texture=texture.name,
            channel=channel,
            uv_set=uv_set,
            wrap_s="repeat" if sampler is None else _wrap(self._samplers[sampler], "wrapS"),
            wrap_t="repeat" if sampler is None else _wrap(self._samplers[sampler], "wrapT"),
            uv_scale=uv_scale,
            uv_rotation_rad=uv_rotation_rad,
            uv_offset=uv_offset,
            scale=scale,
            bias=bias,
        )
        return use, texture

    def derive(self, name: str, picture: Texture) -> Texture:
        """The picture as a texture of the model, under a free name; the same bytes are one texture."""
        if picture.data not in self._by_content:
            texture = replace(picture, name=self._free(name))
            self._by_content[picture.data] = texture
            self.loaded.append(texture)
        return self._by_content[picture.data]

    def _load(self, texture: Json) -> Texture | None:
        """The first source of `texture` that can be had. Findings count only when none can."""
        described = [texture, *(e for name in _SOURCES if (e := texture.extension(name)) is not None)]
        findings: list[Diagnostic] = []
        for candidate in described:
            index = candidate.index("source", self._images, "images")
            if index is None:
                continue
            loaded, diagnostics = self._image(index)
            if loaded is not None:
                return loaded
            findings.extend(diagnostics)
        if not findings:
            findings.append(finding("asset/missing-texture", "the texture names no image", where=texture.where))
        for diagnostic in findings:
            name = diagnostic.code.removeprefix("asset/").replace("-", "_")
            self.notes += repaired(diagnostic, name, texture=texture.pointer)
        return None

    def _image(self, index: int) -> tuple[Texture | None, tuple[Diagnostic, ...]]:
        if index not in self._by_image:
            self._by_image[index] = self._read_image(self._images[index], index)
        return self._by_image[index]

    def _read_image(self, image: Json, index: int) -> tuple[Texture | None, tuple[Diagnostic, ...]]:
        uri = image.get("uri")
        if uri is not None:
            data = read_uri(self._source, uri)
        else:
            view = image.require("bufferView").as_index(self._buffers.views, "bufferViews")
            data = bytes(self._buffers.view(view).data)
        if data is None:
            shown = "" if uri is None else uri.as_string()
            return None, (
                finding("asset/missing-texture", f"the image '{shown}' is absent", where=image.where, value=shown),
            )
        if data in self._by_content:
            return self._by_content[data], ()
        texture, diagnostics = load_texture(data, self._free_name(image, index), where=image.where)
        if texture is not None:
            self._by_content[data] = texture
            self.loaded.append(texture)
        return texture, diagnostics

    def _free_name(self, image: Json, index: int) -> str:
        uri = image.string("uri", "")
        stem = "" if uri[:5].lower() == "data:" else PurePosixPath(unquote(uri).replace("\\", "/")).stem
        return self._free(image.string("name", "") or stem or f"image_{index}")

    def _free(self, name: str) -> str:
        taken = {t.name for t in self.loaded}
        return next(n for n in (name, *(f"{name}_{i}" for i in range(2, len(taken) + 3))) if n not in taken)


def usd_transform(
    scale: tuple[float, float], rotation_rad: float, offset: tuple[float, float]
) -> tuple[tuple[float, float], float, tuple[float, float]]:
    """A KHR_texture_transform, which acts on uvs with v down, as UsdTransform2d values, which act with v up.

    glTF: q' = R S q + o with R = [[c, s], [-s, c]] (the direction that three.js, Blender and the Khronos test model
    agree on). With the flip F(u, v) = (u, 1 - v), F R S F p + ... = R^T S p + (o_u + s S_v, 1 - o_v - c S_v): the
    same scale and angle, counter-clockwise in the v-up plane as USD has it, and another offset.
    """
    c, s = math.cos(rotation_rad), math.sin(rotation_rad)
    return scale, rotation_rad, (offset[0] + s * scale[1], 1.0 - offset[1] - c * scale[1])


def _pair(json: Json, key: str, default: tuple[float, float]) -> tuple[float, float]:
    first, second = json.vector(key, default)
    return first, second


def _wrap(sampler: Json, key: str) -> Wrap:
    mode = sampler.get(key)
    if mode is None:
        return "repeat"
    if mode.as_integer() not in _WRAP:
        raise mode.schema_error(f"there is no wrap mode {mode.as_integer()}")
    return _WRAP[mode.as_integer()]
