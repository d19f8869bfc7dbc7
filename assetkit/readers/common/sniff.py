"""Recognises the format of a file by its first bytes, and refuses files whose content contradicts their extension."""

from __future__ import annotations

import re
from dataclasses import replace

from assetkit.readers.source_format import Signature
from schemas.diagnostics import InvalidInput, Location, finding

LFS_POINTER = b"version https://git-lfs.github.com/spec/"
# Content that is no source format, by its first bytes; expected under the extensions given.
_OTHER_CONTENT = (
    Signature("binary FBX", b"Kaydara FBX Binary"),
    Signature("a Blender file", b"BLENDER", (".blend",)),
    Signature("a PNG image", b"\x89PNG\r\n"),
    Signature("a JPEG image", b"\xff\xd8\xff"),
    Signature("a PDF document", b"%PDF-"),
    Signature("gzip data", b"\x1f\x8b\x08", (".blend",)),
    Signature("a 7z archive", b"7z\xbc\xaf\x27\x1c"),
    Signature("a RAR archive", b"Rar!\x1a\x07"),
)
# Other files than source formats that build on a text syntax.
_OTHER_TEXTS = {"XML": (".urdf", ".xml", ".sdf", ".xacro"), "JSON": (".json",)}
_HTML = re.compile(rb"\s*(<!--.*?-->\s*)*<(!doctype\s+html|html|head|body)\b", re.IGNORECASE | re.DOTALL)
_XML = re.compile(rb"\s*<(\?xml|collada\b)", re.IGNORECASE)
_JSON = re.compile(rb'\s*\{\s*"')
_UTF16 = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}  # byte order marks, Unicode 16.0 section 23.8


def as_utf8(data: bytes) -> bytes:
    """Text with a byte order mark of UTF-16, as some Windows tools save it, as UTF-8; anything else as it is."""
    encoding = _UTF16.get(data[:2])
    return data if encoding is None else data[2:].decode(encoding, "replace").encode()


def sniff(data: bytes) -> tuple[str, tuple[str, ...]] | None:
    """The content by the first bytes: its name and extensions (lower case, with dot). None if they match nothing."""
    from assetkit.readers.by_format import FORMATS  # The readers in that table import this module.

    head = data[:4096].removeprefix(b"\xef\xbb\xbf")
    of_formats = [replace(s, extensions=s.extensions or row.extensions) for row in FORMATS for s in row.magic]
    for signature in (*of_formats, *_OTHER_CONTENT):
        if head.startswith(signature.first_bytes):
            return signature.content, signature.extensions
    if _HTML.match(head):
        return "an HTML page", ()
    for syntax, beginning in (("XML", _XML), ("JSON", _JSON)):
        if beginning.match(head):
            return syntax, (
                *(e for row in FORMATS if row.syntax == syntax for e in row.extensions),
                *_OTHER_TEXTS[syntax],
            )
    return None


def screen(data: bytes, extension: str, *, where: Location) -> None:
    """Return if the first bytes do not contradict `extension` (lower case, no dot).

    Raises InvalidInput `asset/lfs-pointer` for git-LFS pointer text (git-lfs specification, version 1) and
    `asset/wrong-content` for another known format or a web page under this name.
    """
    if data.lstrip()[: len(LFS_POINTER)] == LFS_POINTER:
        raise InvalidInput(finding("asset/lfs-pointer", "git-LFS pointer text stands in for the asset", where=where))
    known = sniff(data)
    if known is not None and f".{extension}" not in known[1]:
        raise InvalidInput(
            finding(
                "asset/wrong-content",
                f"the file is named .{extension} but holds {known[0]}",
                where=where,
                value=known[0],
                bound=extension,
            )
        )


def screen_text(data: bytes, extension: str, *, where: Location) -> None:
    """As `screen`, and NUL bytes in the first 4096 are `asset/wrong-content` too: the format is text."""
    screen(data, extension, where=where)
    if b"\x00" in data[:4096]:
        raise InvalidInput(
            finding("asset/wrong-content", f"the file is named .{extension} but holds binary data", where=where)
        )
