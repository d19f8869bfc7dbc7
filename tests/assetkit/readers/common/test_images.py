"""Textures: original bytes survive, damage and bombs are found, in bounded memory."""

import io
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from assetkit.readers.common.images import load_texture
from schemas.appearance.material import Texture
from schemas.diagnostics import InvalidInput, Location, Severity

WHERE = Location(file="a.glb", prim="/images/0")
PIXELS = np.random.default_rng(0).integers(0, 256, (24, 32, 3), dtype=np.uint8)


def encoded(format_: str, mode: str = "RGB") -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(PIXELS).convert(mode).save(buffer, format_, lossless=True)
    return buffer.getvalue()


def bomb_png(width: int, height: int, depth: int = 8, colour_type: int = 0) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, depth, colour_type, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0")) + chunk(b"IEND", b"")


@pytest.mark.parametrize(("format_", "extension"), [("PNG", "png"), ("JPEG", "jpg")])
def test_png_and_jpeg_keep_their_bytes(format_, extension):
    data = encoded(format_)
    texture, diagnostics = load_texture(data, "wood", where=WHERE)
    assert diagnostics == ()
    assert texture == Texture("wood", data, extension, 32, 24)


@pytest.mark.parametrize("format_", ["WEBP", "BMP", "TGA", "TIFF"])
def test_other_formats_become_png_without_loss(format_):
    texture, diagnostics = load_texture(encoded(format_), "wood", where=WHERE)
    assert diagnostics == ()
    assert texture is not None
    assert texture.extension == "png"
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(texture.data))), PIXELS)
    assert load_texture(encoded(format_), "wood", where=WHERE)[0] == texture  # same bytes every time


def test_gif_palette_becomes_rgb():
    texture, _ = load_texture(encoded("GIF", "P"), "logo", where=WHERE)
    assert texture is not None
    assert Image.open(io.BytesIO(texture.data)).mode == "RGB"


@pytest.mark.parametrize("data", [b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80), bytes(4) + b"ftypavif" + bytes(9)])
def test_gpu_containers_are_unsupported(data):
    texture, (diagnostic,) = load_texture(data, "t", where=WHERE)
    assert texture is None
    assert (diagnostic.code, diagnostic.severity) == ("asset/unsupported-texture", Severity.WARNING)
    assert diagnostic.where == WHERE


@pytest.mark.parametrize(
    "data",
    [
        b"",
        encoded("PNG")[: len(encoded("PNG")) // 2],
        encoded("JPEG")[: len(encoded("JPEG")) // 2],
        encoded("WEBP")[:60],
        encoded("PNG")[:60] + b"\0" * 100 + encoded("PNG")[160:],
        b"<html><body>404</body></html>",
        b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 3\n",
        bytes(200),
    ],
)
def test_damage_is_found_by_decoding(data):
    texture, (diagnostic,) = load_texture(data, "t", where=WHERE)
    assert texture is None
    assert (diagnostic.code, diagnostic.severity) == ("asset/corrupt-texture", Severity.WARNING)


@pytest.mark.parametrize(
    "data",
    [
        bomb_png(20000, 20000),
        bomb_png(8193, 8192),
        bomb_png(2**31 - 1, 2**31 - 1),
        bomb_png(8192, 4097, depth=16, colour_type=6),
        encoded("BMP")[:18] + struct.pack("<ii", 30000, 30000) + encoded("BMP")[26:],
    ],
)
def test_bombs_are_refused_by_their_header(data):
    tracemalloc.start()
    with pytest.raises(InvalidInput) as caught:
        load_texture(data, "bomb", where=WHERE)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert caught.value.diagnostic.code == "asset/resource-limit"
    assert peak < 2**20


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(["PNG", "JPEG", "WEBP", "BMP", "TGA", "GIF", "TIFF"]),
    st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), max_size=6),
    st.integers(0, 3000),
)
def test_arbitrary_damage_never_escapes(format_, edits, length):
    data = bytearray(encoded(format_))
    for position, value in edits:
        data[position % len(data)] = value
    try:
        texture, diagnostics = load_texture(bytes(data[:length]), "t", where=WHERE)
    except InvalidInput:
        return  # The damage hit the size field.
    assert (texture is None) == (len(diagnostics) == 1)


def test_dds_textures_are_decoded_and_damaged_ones_named():
    texture, diagnostics = load_texture(encoded("DDS"), "wood", where=WHERE)
    assert diagnostics == ()
    assert texture is not None
    assert texture.extension == "png"
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(texture.data)).convert("RGB")), PIXELS)
    texture, (diagnostic,) = load_texture(b"DDS " + bytes(124), "wood", where=WHERE)
    assert (texture, diagnostic.code) == (None, "asset/corrupt-texture")
