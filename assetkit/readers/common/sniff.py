"""Recognises the format of a file by its first bytes, and refuses files whose content contradicts their extension."""

from __future__ import annotations

import re

from schemas.diagnostics import InvalidInput, Location, finding

LFS_POINTER = b"version https://git-lfs.github.com/spec/"
# (what it is, extensions under which it is expected, first bytes)
_MAGIC: tuple[tuple[str, tuple[str, ...], bytes], ...] = (
    ("binary glTF", ("glb",), b"glTF"),
    ("USD crate", ("usd", "usdc"), b"PXR-USDC"),
    ("USD text", ("usd", "usda"), b"#usda"),
    ("a ZIP archive", ("usdz",), b"PK\x03\x04"),
    ("PLY", ("ply",), b"ply\n"),
    ("PLY", ("ply",), b"ply\r"),
    ("binary FBX", (), b"Kaydara FBX Binary"),
    ("a Blender file", ("blend",), b"BLENDER"),
    ("a PNG image", (), b"\x89PNG\r\n"),
    ("a JPEG image", (), b"\xff\xd8\xff"),
    ("a PDF document", (), b"%PDF-"),
    ("gzip data", ("blend",), b"\x1f\x8b\x08"),
    ("a 7z archive", (), b"7z\xbc\xaf\x27\x1c"),
    ("a RAR archive", (), b"Rar!\x1a\x07"),
)
_HTML = re.compile(rb"\s*(<!--.*?-->\s*)*<(!doctype\s+html|html|head|body)\b", re.IGNORECASE | re.DOTALL)
_XML = re.compile(rb"\s*<(\?xml|collada\b)", re.IGNORECASE)
_JSON = re.compile(rb'\s*\{\s*"')


def sniff(data: bytes) -> tuple[str, tuple[str, ...]] | None:
    """The format by the first bytes: its name and extensions (lower case, no dot). None if they match no format."""
    head = data[:4096].removeprefix(b"\xef\xbb\xbf")
    for name, extensions, magic in _MAGIC:
        if head.startswith(magic):
            return name, extensions
    if _HTML.match(head):
        return "an HTML page", ()
    if _XML.match(head):
        return "XML", ("dae", "urdf", "xml", "sdf", "xacro")
    if _JSON.match(head):
        return "JSON", ("gltf", "json")
    return None


def screen(data: bytes, extension: str, *, where: Location) -> None:
    """Return if the first bytes do not contradict `extension` (lower case, no dot).

    Raises InvalidInput `asset/lfs-pointer` for git-LFS pointer text (git-lfs specification, version 1) and
    `asset/wrong-content` for another known format or a web page under this name.
    """
    if data.lstrip()[: len(LFS_POINTER)] == LFS_POINTER:
        raise InvalidInput(finding("asset/lfs-pointer", "git-LFS pointer text stands in for the asset", where=where))
    known = sniff(data)
    if known is not None and extension not in known[1]:
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
