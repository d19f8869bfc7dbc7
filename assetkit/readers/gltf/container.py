"""From the bytes of a .gltf or .glb file to its JSON document and binary chunk (glTF 2.0, section 4)."""

from __future__ import annotations

import json
import struct
from typing import Final, NoReturn

from assetkit.readers.common.sniff import screen
from assetkit.readers.gltf.json import Json
from schemas.diagnostics import InvalidInput, Location, finding

_MAGIC: Final = b"glTF"
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942


def parse_container(data: bytes, extension: str, where: Location) -> tuple[Json, memoryview | None]:
    """The JSON document (an object) and the binary chunk of `data`, a file named `.extension` (lower case, no dot).

    Raises InvalidInput: `asset/lfs-pointer` and `asset/wrong-content` for other content under this name,
    `asset/truncated` when lengths exceed the file, `asset/format-unsupported` for glTF versions other than 2,
    `asset/parse-error` for a bad magic, a bad chunk order or a JSON syntax error (with line and column) and
    `asset/schema-error` when the document is no object or has no version.
    """
    screen(data, extension, where=where)
    text, chunk = _glb_chunks(data, where) if extension == "glb" else (data, None)
    document = Json(_parse_json(text, where), where.file or "")
    _check_version(document)
    return document, chunk


def _glb_chunks(data: bytes, where: Location) -> tuple[bytes, memoryview | None]:
    if not data.startswith(_MAGIC[: max(len(data), 1)]) and len(data) > 0:
        _fail("asset/parse-error", f"the file starts with {data[:4]!r}, not with the magic {_MAGIC!r}", where)
    if len(data) < 12:
        _truncated("the GLB header", 12, len(data), where)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        _fail("asset/format-unsupported", f"GLB version {version} is not read, only version 2", where)
    if length > len(data):
        _truncated("the GLB header announces a file that", length, len(data), where)
    chunks = _split_chunks(memoryview(data)[:length], where)
    if not chunks or chunks[0][0] != _JSON_CHUNK:
        _fail("asset/parse-error", "the first chunk of the GLB is not JSON", where)
    binary = chunks[1][1] if len(chunks) > 1 and chunks[1][0] == _BINARY_CHUNK else None
    return bytes(chunks[0][1]).rstrip(b"\0 "), binary


def _split_chunks(data: memoryview, where: Location) -> list[tuple[int, memoryview]]:
    chunks: list[tuple[int, memoryview]] = []
    position = 12
    while position < len(data):
        if position + 8 > len(data):
            _truncated(f"the header of chunk {len(chunks)}", position + 8, len(data), where)
        length, kind = struct.unpack_from("<II", data, position)
        end = position + 8 + length
        if end > len(data):
            _truncated(f"chunk {len(chunks)}", end, len(data), where)
        chunks.append((kind, data[position + 8 : end]))
        position = end
    return chunks


def _parse_json(text: bytes, where: Location) -> object:
    try:
        return json.loads(text.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        at = where.model_copy(update={"line": error.lineno, "column": error.colno})
        _fail("asset/parse-error", f"JSON: {error.msg}", at)
    except RecursionError:
        _fail("asset/parse-error", "JSON: nested too deeply", where)
    except ValueError as error:  # Not UTF-8, NaN or Infinity, or a number with thousands of digits.
        _fail("asset/parse-error", f"JSON: {error}", where)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a JSON number")


def _check_version(document: Json) -> None:
    asset = document.require("asset")
    for key in ("version", "minVersion"):
        version = asset.string(key, "2.0") if key == "minVersion" else asset.require(key).as_string()
        major, _, minor = version.partition(".")
        if major != "2" or (key == "minVersion" and minor != "0"):
            where = asset.require(key).where
            _fail("asset/format-unsupported", f"glTF {key} {version!r} is not read, only 2.0", where)


def _truncated(what: str, needed: int, present: int, where: Location) -> NoReturn:
    headline = f"{what} needs {needed} bytes, the file has {present}"
    raise InvalidInput(finding("asset/truncated", headline, where=where, value=present, bound=needed, unit="bytes"))


def _fail(code: str, headline: str, where: Location) -> NoReturn:
    raise InvalidInput(finding(code, headline, where=where))
