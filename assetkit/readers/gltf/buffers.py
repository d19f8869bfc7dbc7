"""Reads buffers and buffer views: bytes from the GLB chunk, data URIs, files and EXT_meshopt_compression."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from urllib.parse import unquote_to_bytes

import meshoptimizer
import numpy as np

from assetkit.readers.gltf.json import Json
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput, finding

MAX_BUFFER_BYTES: Final = 2**30


@dataclass(frozen=True)
class View:
    """The bytes of one buffer view; `stride` in bytes, None when elements are packed."""

    data: memoryview
    stride: int | None


class Buffers:
    """Lazily opened buffers of one document; nothing is opened that no accessor or image refers to."""

    def __init__(self, source: SourceFile, document: Json, chunk: memoryview | None) -> None:
        self._source = source
        self._document = document
        self._chunk = chunk
        self._data: dict[int, memoryview] = {}
        self._views: dict[int, View] = {}

    @cached_property
    def views(self) -> tuple[Json, ...]:
        """The buffer views as the document describes them."""
        return self._document.items("bufferViews")

    @cached_property
    def _buffers(self) -> tuple[Json, ...]:
        return self._document.items("buffers")

    def view(self, index: int) -> View:
        """Buffer view `index`, decompressed.

        Raises InvalidInput: `asset/accessor-out-of-bounds` when it passes the end its buffer declares,
        `asset/truncated` when the buffer is shorter than declared, `asset/missing-dependency` when it is absent,
        `asset/parse-error` for damaged compressed data, `asset/resource-limit` above 1 GiB decoded.
        """
        if index not in self._views:
            view = self.views[index]
            packed = view.extension("EXT_meshopt_compression")
            data = self._slice(view) if packed is None else _meshopt(packed, self._slice(packed))
            stride = view.get("byteStride")
            self._views[index] = View(data, None if stride is None else stride.as_integer(1))
        return self._views[index]

    def _slice(self, view: Json) -> memoryview:
        index = view.require("buffer").as_index(self._buffers, "buffers")
        start = view.integer("byteOffset", 0)
        end = start + view.integer("byteLength")
        declared = self._buffers[index].integer("byteLength")
        if end > declared:
            headline = f"the view ends at byte {end} of a buffer of {declared}"
            raise InvalidInput(
                finding(
                    "asset/accessor-out-of-bounds", headline, where=view.where, value=end, bound=declared, unit="bytes"
                )
            )
        data = self._buffer(index)
        if end > len(data):
            headline = f"buffer {index} declares {declared} bytes but holds {len(data)}"
            raise InvalidInput(
                finding("asset/truncated", headline, where=view.where, value=len(data), bound=end, unit="bytes")
            )
        return data[start:end]

    def _buffer(self, index: int) -> memoryview:
        if index not in self._data:
            buffer = self._buffers[index]
            uri = buffer.get("uri")
            data = self._embedded(index) if uri is None else read_uri(self._source, uri)
            if data is None:
                name = "its data" if uri is None else f"'{uri.as_string()}'"
                raise InvalidInput(
                    finding("asset/missing-dependency", f"buffer {index}: {name} is absent", where=buffer.where)
                )
            self._data[index] = memoryview(data)
        return self._data[index]

    def _embedded(self, index: int) -> memoryview | None:
        """The GLB's binary chunk, which is buffer 0 if anything (glTF 2.0, 4.4.3.3)."""
        return self._chunk if index == 0 else None


def read_uri(source: SourceFile, uri: Json) -> bytes | None:
    """The bytes a `uri` member names: a data URI or a file below the asset's root; None when the file is absent.

    Raises InvalidInput as `SourceFile.resolve` does, and `asset/parse-error` for a broken data URI (RFC 2397).
    """
    text = uri.as_string()
    if text[:5].lower() != "data:":
        try:
            path = source.resolve(text, where=uri.where)
            return None if path is None else path.read_bytes()
        except (OSError, ValueError):  # A name no file can have, or a file that cannot be read: as good as absent.
            return None
    header, comma, body = text.partition(",")
    try:
        if not comma:
            raise ValueError("it has no comma")
        raw = unquote_to_bytes(body)
        if not header.lower().endswith(";base64"):
            return raw
        return base64.b64decode(b"".join(raw.split()), validate=True)
    except (binascii.Error, ValueError) as error:
        raise InvalidInput(finding("asset/parse-error", f"broken data URI: {error}", where=uri.where)) from error


def _meshopt(packed: Json, data: memoryview) -> memoryview:
    """The decoded bytes of an EXT_meshopt_compression view: `count` elements of `byteStride` bytes."""
    count, stride = packed.integer("count"), packed.integer("byteStride", minimum=1)
    mode, filter_ = packed.require("mode").as_string(), packed.string("filter", "NONE")
    if count * stride > MAX_BUFFER_BYTES:
        headline = f"the compressed view expands to {count * stride} bytes"
        raise InvalidInput(
            finding(
                "asset/resource-limit",
                headline,
                where=packed.where,
                value=count * stride,
                bound=MAX_BUFFER_BYTES,
                unit="bytes",
            )
        )
    _check_meshopt(packed, mode, filter_, count, stride)
    raw = np.frombuffer(data, dtype=np.uint8)
    try:
        if mode == "ATTRIBUTES":
            decoded = meshoptimizer.decode_vertex_buffer(count, stride, raw)
        elif mode == "TRIANGLES":
            decoded = meshoptimizer.decode_index_buffer(count, stride, raw)
        else:
            decoded = meshoptimizer.decode_index_sequence(count, stride, raw)
    except (RuntimeError, ValueError) as error:
        headline = f"damaged meshopt data: {error}"
        raise InvalidInput(finding("asset/parse-error", headline, where=packed.where)) from error
    # The binding returns wider elements than `stride` for 16-bit indices; the decoded bytes come first.
    octets = decoded.reshape(-1).view(np.uint8)[: count * stride]
    if filter_ == "OCTAHEDRAL":
        octets = meshoptimizer.decode_filter_oct(octets, count, stride)
    elif filter_ == "QUATERNION":
        octets = meshoptimizer.decode_filter_quat(octets, count, stride)
    elif filter_ == "EXPONENTIAL":
        octets = meshoptimizer.decode_filter_exp(octets, count, stride)
    return memoryview(octets.tobytes())


def _check_meshopt(packed: Json, mode: str, filter_: str, count: int, stride: int) -> None:
    """The sizes the native decoder takes for granted (EXT_meshopt_compression, section Compressed Data Format)."""
    strides = {"NONE": range(4, 257, 4), "OCTAHEDRAL": (4, 8), "QUATERNION": (8,), "EXPONENTIAL": range(4, 257, 4)}
    if mode == "ATTRIBUTES":
        valid = filter_ in strides and stride in strides[filter_]
    else:
        valid = mode in {"TRIANGLES", "INDICES"} and filter_ == "NONE" and stride in (2, 4)
        valid = valid and (mode == "INDICES" or count % 3 == 0)
    if not valid:
        raise packed.schema_error(f"mode {mode}, filter {filter_}, count {count} and stride {stride} do not fit")
