"""Builds small glTF files for the tests of the glTF reader."""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from assetkit.readers.gltf.read import read_gltf
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import Diagnostic, InvalidInput
from schemas.model import Mesh, Model
from schemas.outcome import Outcome

COMPONENT = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPE = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
# A tetrahedron with outward faces.
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype="<u2")


class GltfFile:
    """A document and its binary chunk, grown by `accessor`, `image` and plain edits of `doc`."""

    def __init__(self) -> None:
        self.doc: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}
        self.blob = bytearray()

    def view(self, data: bytes, **extra: Any) -> int:
        self.blob += bytes(-len(self.blob) % 4)
        self.doc["bufferViews"].append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), **extra})
        self.blob += data
        return len(self.doc["bufferViews"]) - 1

    def accessor(self, array: np.ndarray, **extra: Any) -> int:
        array = np.asarray(array)
        columns = 1 if array.ndim == 1 else array.shape[1]
        described = {"componentType": COMPONENT[array.dtype.str[1:]], "count": len(array), "type": TYPE[columns]}
        self.doc["accessors"].append({"bufferView": self.view(array.tobytes()), **described, **extra})
        return len(self.doc["accessors"]) - 1

    def image(self, data: bytes, **extra: Any) -> int:
        """A texture whose image is embedded; returns its index."""
        images, textures = self.doc.setdefault("images", []), self.doc.setdefault("textures", [])
        images.append({"bufferView": self.view(data), "mimeType": "image/png", **extra})
        textures.append({"source": len(images) - 1})
        return len(textures) - 1

    def mesh(self, attributes: dict[str, int], **extra: Any) -> int:
        meshes = self.doc.setdefault("meshes", [])
        meshes.append({"primitives": [{"attributes": attributes, **extra}]})
        return len(meshes) - 1

    def show(self, *nodes: dict[str, Any]) -> GltfFile:
        """Append `nodes` and make a scene of them."""
        own = self.doc.setdefault("nodes", [])
        self.doc["scenes"] = [{"nodes": list(range(len(own), len(own) + len(nodes)))}]
        self.doc["scene"] = 0
        own.extend(nodes)
        return self

    def glb(self) -> bytes:
        doc = {**self.doc}
        if self.blob:
            doc.setdefault("buffers", [{"byteLength": len(self.blob)}])
        text = json.dumps({k: v for k, v in doc.items() if v != []}).encode()
        text += b" " * (-len(text) % 4)
        blob = bytes(self.blob) + bytes(-len(self.blob) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if blob:
            chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri: str | None = None) -> bytes:
        """The text form; its buffer is a data URI unless `uri` names a file."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(bytes(self.blob)).decode()
        return json.dumps({**self.doc, "buffers": [{"byteLength": len(self.blob), "uri": uri}]}, indent=1).encode()


def tetrahedron(**extra: Any) -> GltfFile:
    """A file with one tetrahedron mesh under one node; `extra` are more members of its primitive."""
    file = GltfFile()
    attributes = {"POSITION": file.accessor(POINTS), **extra.pop("attributes", {})}
    file.mesh(attributes, indices=file.accessor(FACES.reshape(-1)), **extra)
    return file.show({"mesh": 0})


def read(folder: Path, data: bytes, name: str = "part.glb") -> Outcome[Model]:
    path = folder / name
    path.write_bytes(data)
    return read_gltf(SourceFile(path, folder))


def model(folder: Path, file: GltfFile) -> Model:
    value = read(folder, file.glb()).value
    assert value is not None
    return value


def png(mode: str = "RGB", seed: int = 0) -> bytes:
    pixels = np.random.default_rng(seed).integers(0, 256, (8, 8, 4), dtype=np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(pixels, "RGBA").convert(mode).save(buffer, "PNG")
    return buffer.getvalue()


def refused(folder: Path, data: bytes, name: str = "part.glb") -> Diagnostic:
    """The finding that stops the reader."""
    with pytest.raises(InvalidInput) as caught:
        read(folder, data, name)
    return caught.value.diagnostic


def signed_volume(mesh: Mesh) -> float:
    """Volume enclosed by `mesh`, positive when its faces point outwards (divergence theorem)."""
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", np.cross(a, b), c)) / 6.0
