"""VTK textures from encoded images: decoded, shrunk to 1024 px, in the right colour space."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkTexture
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLTexture

from schemas.appearance.material import Texture

MAX_EDGE_PX = 1024  # A 512 px picture with 2 x 2 samples shows no more.


class TextureSet:
    """The GPU textures of one model, decoded and uploaded once per image and colour space."""

    def __init__(self, sources: tuple[Texture, ...]) -> None:
        self._sources = {texture.name: texture.data for texture in sources}
        self._images: dict[str, np.ndarray | None] = {}
        self._textures: dict[tuple[str, bool, bool], vtkTexture] = {}

    def get(self, name: str, *, srgb: bool, repeat: bool) -> vtkTexture | None:
        """The texture `name`, or None when the model has no such image or it does not decode.

        `srgb`: texels are decoded to linear by the sampler. `repeat`: tiles outside 0..1, else the edge is continued.
        """
        if name not in self._images:
            data = self._sources.get(name)
            self._images[name] = None if data is None else decode_rgba(data)
        pixels = self._images[name]
        if pixels is None:
            return None
        key = (name, srgb, repeat)
        if key not in self._textures:
            self._textures[key] = _texture(pixels, srgb=srgb, repeat=repeat)
        return self._textures[key]


def decode_rgba(data: bytes) -> np.ndarray | None:
    """(height, width, 4) uint8, first row at the bottom, longest edge at most MAX_EDGE_PX; None if undecodable."""
    try:
        with Image.open(io.BytesIO(data)) as image:
            image.draft("RGB", (MAX_EDGE_PX, MAX_EDGE_PX))  # JPEG: decode at a fraction of the size.
            return _shrunk_rgba(image)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None  # Readers have reported damaged images; the picture shows the scalar value instead.


def _shrunk_rgba(image: Image.Image) -> np.ndarray:
    factor = -(-max(image.size) // MAX_EDGE_PX)
    if image.mode.startswith("I"):  # 16 bit; Pillow's own conversion clips at 255.
        image = Image.fromarray((np.asarray(image, dtype=np.int64) >> 8).clip(0, 255).astype(np.uint8))
    if image.mode == "P" or "transparency" in image.info:
        image = image.convert("RGBA")
    if factor > 1:
        image = image.reduce(factor)
    return np.ascontiguousarray(np.asarray(image.convert("RGBA"))[::-1])


def _texture(pixels: np.ndarray, *, srgb: bool, repeat: bool) -> vtkTexture:
    height, width = pixels.shape[:2]
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(pixels.reshape(-1, 4), deep=True))
    texture = vtkOpenGLTexture()
    texture.SetInputData(image)
    texture.SetColorModeToDirectScalars()
    texture.SetUseSRGBColorSpace(srgb)
    texture.MipmapOn()
    texture.InterpolateOn()
    texture.SetMaximumAnisotropicFiltering(1.0)  # llvmpipe's filter took 7 s for one picture of stretched UVs.
    texture.SetWrap(vtkTexture.Repeat if repeat else vtkTexture.ClampToEdge)
    return texture
