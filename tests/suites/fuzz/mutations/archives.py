"""Damage to archives (USDZ) and pictures: entries, compression, nesting, declared sizes."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
import zlib
from random import Random

from schemas.files.zip_damage import ZIP_DAMAGE
from tests.suites.fuzz.mutations.raw_bytes import BINARY, flip_bits, odd_words

_BOMB_BYTES = 160 * 2**20
_ODD_ENTRIES = (
    "x.usda",
    "a/b.png",
    "x" * 200,
    "é.usdc",
    "../outside/secret.usda",
    "/etc/x.usda",
    "new\nline.usda",
)
_IHDR_SIZES = ((40_000, 40_000), (2**31 - 1, 2**31 - 1), (0, 0), (1, 2**30), (65_535, 65_535))


def edit_package(rng: Random, data: bytes) -> bytes:
    """A USDZ whose entries are damaged, doubled, renamed, nested, compressed or dropped."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            if sum(e.file_size for e in package.infolist()) > _BOMB_BYTES // 2:
                return flip_bits(rng, data)
            entries = [(e.filename, package.read(e)) for e in package.infolist()]
    except ZIP_DAMAGE:
        return flip_bits(rng, data)
    i, method = rng.randrange(len(entries) or 1), zipfile.ZIP_STORED
    name, content = entries[i] if entries else ("x.usda", b"")
    match rng.randrange(9):
        case 0:
            entries = entries[:i] + entries[i + 1 :]
        case 1:
            entries.append((name, content))
        case 2 if entries:
            entries[i] = (rng.choice((*_ODD_ENTRIES, name.upper())), content)
        case 3:
            entries.append((rng.choice(("inner.usdz", "0.usdz")), data))
        case 4:
            entries, method = [*entries, ("zeros.png", bytes(_BOMB_BYTES))], zipfile.ZIP_DEFLATED
        case 5:
            method = zipfile.ZIP_DEFLATED
        case 6:
            entries.reverse()
        case _ if entries and content:
            entries[i] = (name, rng.choice(BINARY)(rng, content))
    return _packed(entries, method)


def _packed(entries: list[tuple[str, bytes]], method: int) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method, compresslevel=1) as package, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # A name that occurs twice is what is wanted here.
        for name, content in entries:
            package.writestr(zipfile.ZipInfo(name), content, method)
    return out.getvalue()


def odd_picture_size(rng: Random, data: bytes) -> bytes:
    """A PNG that declares another size, with a right checksum; another file has odd words."""
    if data[:8] != b"\x89PNG\r\n\x1a\n" or len(data) < 33:
        return odd_words(rng, data)
    header = b"IHDR" + struct.pack(">II", *rng.choice(_IHDR_SIZES)) + data[24:29]
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]
