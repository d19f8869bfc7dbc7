"""Loads image files of assets as textures: recognised by content, size checked before decoding, bytes kept."""

from __future__ import annotations

import io
from typing import Final

from PIL import (
    BmpImagePlugin,
    DdsImagePlugin,
    GifImagePlugin,
    Image,
    ImageFile,
    JpegImagePlugin,
    PngImagePlugin,
    TgaImagePlugin,
    TiffImagePlugin,
    WebPImagePlugin,
)

from schemas.appearance.material import Texture
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding

MAX_PIXELS: Final = 8192 * 8192
MAX_IMAGE_BYTES: Final = 256 * 2**20

# Plugins are called directly: `Image.open` would try fifty formats and run its own, weaker, bomb check first.
_DECODERS: tuple[tuple[bytes, type[ImageFile.ImageFile]], ...] = (
    (b"\x89PNG\r\n\x1a\n", PngImagePlugin.PngImageFile),
    (b"\xff\xd8\xff", JpegImagePlugin.JpegImageFile),
    (b"DDS ", DdsImagePlugin.DdsImageFile),
    (b"BM", BmpImagePlugin.BmpImageFile),
    (b"GIF87a", GifImagePlugin.GifImageFile),
    (b"GIF89a", GifImagePlugin.GifImageFile),
    (b"II*\x00", TiffImagePlugin.TiffImageFile),
    (b"MM\x00*", TiffImagePlugin.TiffImageFile),
)
_UNSUPPORTED: tuple[tuple[bytes, str], ...] = (
    (b"\xabKTX 20\xbb", "KTX2"),
    (b"\xabKTX 11\xbb", "KTX"),
    (b"sB", "Basis Universal"),
    (b"PVR\x03", "PVR"),
    (b"v/1\x01", "OpenEXR"),
    (b"#?R", "Radiance HDR"),
    (b"8BPS", "Photoshop"),
    (b"\x00\x00\x00\x0cjP  ", "JPEG 2000"),
    (b"<svg", "SVG"),
)


def load_texture(data: bytes, name: str, *, where: Location) -> tuple[Texture | None, tuple[Diagnostic, ...]]:
    """The texture in `data`, called `name`, or None with a warning for the reason.

    PNG and JPEG keep their bytes; WebP, BMP, TGA, DDS, GIF (first frame) and TIFF (first page) become PNG. The image
    is decoded in full once, so that damage shows here and not in a renderer. Warnings: `asset/unsupported-texture` for
    containers that need a GPU transcoder or another decoder, `asset/corrupt-texture` for bytes that do not decode.

    Raises InvalidInput (`asset/resource-limit`) when the header announces more than 8192 x 8192 pixels or 256 MiB
    decoded; nothing is decoded then.
    """
    unsupported = _unsupported_container(data)
    if unsupported:
        headline = f"texture '{name}' is a {unsupported} image, which is not decoded here"
        return None, (finding("asset/unsupported-texture", headline, where=where, value=unsupported),)
    try:
        image = _decoder(data)(io.BytesIO(data))
        _check_size(image, name, where)
        image.load()
        return _texture(image, data, name), ()
    except (InvalidInput, MemoryError):
        raise
    except Image.DecompressionBombError as error:  # The WebP plugin refuses before it gives the size.
        raise _too_large(f"texture '{name}': {error}", where, None) from error
    except Exception as error:  # On damaged bytes Pillow's plugins raise whatever their parsing trips over.
        headline = f"texture '{name}' cannot be decoded: {_reason(data, error)}"
        return None, (finding("asset/corrupt-texture", headline, where=where, value=len(data), unit="bytes"),)


def _unsupported_container(data: bytes) -> str | None:
    if data[4:8] == b"ftyp":
        return "AVIF or HEIF"
    return next((name for magic, name in _UNSUPPORTED if data.startswith(magic)), None)


def _decoder(data: bytes) -> type[ImageFile.ImageFile]:
    """The plugin for the magic bytes; TGA has none, so it is what remains and checks its own header."""
    if data.startswith(b"RIFF") and data[8:12] == b"WEBP":
        return WebPImagePlugin.WebPImageFile
    return next((plugin for magic, plugin in _DECODERS if data.startswith(magic)), TgaImagePlugin.TgaImageFile)


def _check_size(image: ImageFile.ImageFile, name: str, where: Location) -> None:
    """Refuse by header alone. 16-bit files count 8 bytes per pixel: renderers keep them so, Pillow does not."""
    width, height = image.size
    sixteen_bit = any("16" in str(tile[3]) for tile in image.tile)
    decoded_bytes = width * height * (8 if sixteen_bit else 4)
    if width * height <= MAX_PIXELS and decoded_bytes <= MAX_IMAGE_BYTES:
        return
    raise _too_large(f"texture '{name}' has {width} x {height} pixels", where, decoded_bytes)


def _too_large(headline: str, where: Location, decoded_bytes: int | None) -> InvalidInput:
    return InvalidInput(
        finding(
            "asset/resource-limit",
            headline,
            where=where,
            value=decoded_bytes,
            bound=MAX_IMAGE_BYTES,
            unit="bytes decoded",
        )
    )


def _texture(image: ImageFile.ImageFile, data: bytes, name: str) -> Texture:
    width, height = image.size
    if isinstance(image, PngImagePlugin.PngImageFile):
        return Texture(name, data, "png", width, height)
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        return Texture(name, data, "jpg", width, height)
    return Texture(name, _as_png(image), "png", width, height)


def _as_png(image: Image.Image) -> bytes:
    """Lossless PNG bytes of the decoded pixels; palettes and rare colour models become RGB or RGBA."""
    if image.mode not in {"L", "LA", "RGB", "RGBA", "I;16"}:
        image = image.convert("RGBA" if image.has_transparency_data else "RGB")
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    return buffer.getvalue()


def _reason(data: bytes, error: Exception) -> str:
    if not data:
        return "it is empty"
    if data.startswith(b"version https://git-lfs"):
        return "it is a git-LFS pointer, not the image"
    return str(error) or type(error).__name__
