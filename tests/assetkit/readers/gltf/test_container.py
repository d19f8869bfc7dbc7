"""glTF files, buffers and JSON types: what is refused, for which reason and at which place."""

import struct
from typing import Any

import numpy as np
import pytest

from tests.support.gltf_files import FACES, POINTS, model, read, refused, tetrahedron

# Containers.


def test_text_and_binary_form_give_the_same_model(tmp_path):
    file = tetrahedron()
    (tmp_path / "räder 1.bin").write_bytes(bytes(file.blob))
    binary = model(tmp_path, file).meshes[0]
    for data in (file.gltf(), file.gltf("r%C3%A4der%201.bin")):
        value = read(tmp_path, data, "part.gltf").value
        assert value is not None
        assert np.array_equal(value.meshes[0].points, binary.points)
        assert np.array_equal(value.meshes[0].triangles, binary.triangles)
    assert np.array_equal(binary.points, POINTS)
    assert np.array_equal(binary.triangles, FACES)


def test_every_cut_of_a_glb_is_truncated(tmp_path):
    data = tetrahedron().glb()
    assert {refused(tmp_path, data[:n]).code for n in range(len(data))} == {"asset/truncated"}


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"<!DOCTYPE html><html></html>", "asset/wrong-content"),
        (b"\x89PNG\r\n\x1a\n" + bytes(40), "asset/wrong-content"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "asset/lfs-pointer"),
        (bytes(12), "asset/parse-error"),
        (b"glTF" + struct.pack("<II", 1, 12), "asset/format-unsupported"),
        (b"glTF" + struct.pack("<II", 2, 12), "asset/parse-error"),
        (b"glTF" + struct.pack("<IIII", 2, 24, 4, 0x004E4942) + bytes(4), "asset/parse-error"),
        (b"glTF" + struct.pack("<IIII", 2, 24, 4, 0x4E4F534A) + b"{\n]}", "asset/parse-error"),
        (b"glTF" + struct.pack("<IIII", 2, 24, 4, 0x4E4F534A) + b"\xff\xff{}", "asset/parse-error"),
        (b"glTF" + struct.pack("<IIII", 2, 24, 4, 0x4E4F534A) + b"[1] ", "asset/schema-error"),
    ],
)
def test_bad_containers(tmp_path, data, code):
    assert refused(tmp_path, data).code == code


def test_json_errors_carry_line_and_column(tmp_path):
    where = refused(tmp_path, b'{"asset": {},\n  "nodes": [1,]}', "part.gltf").where
    assert (where.file, where.line, where.column) == ("part.gltf", 2, 15)
    assert refused(tmp_path, b'{"asset": NaN}', "part.gltf").code == "asset/parse-error"
    assert refused(tmp_path, b'{"a": ' + b"[" * 100_000, "part.gltf").code == "asset/parse-error"


@pytest.mark.parametrize("asset", [{"version": "1.0"}, {"version": "2.0", "minVersion": "2.1"}])
def test_other_versions(tmp_path, asset):
    file = tetrahedron()
    file.doc["asset"] = asset
    assert refused(tmp_path, file.glb()).code == "asset/format-unsupported"


def test_unknown_required_extension(tmp_path):
    file = tetrahedron()
    file.doc["extensionsRequired"] = ["KHR_mesh_quantization", "ACME_secret"]
    diagnostic = refused(tmp_path, file.glb())
    assert (diagnostic.code, diagnostic.value) == ("asset/unsupported-required-extension", "ACME_secret")
    assert diagnostic.where.prim == "/extensionsRequired/1"


# Buffers.


@pytest.mark.parametrize(
    ("uri", "code"),
    [
        ("absent.bin", "asset/missing-dependency"),
        ("%2e%2e/%2e%2e/secret.bin", "asset/path-escape"),
        ("https://example.com/a.bin", "asset/remote-reference"),
        ("data:;base64,@@@@@", "asset/parse-error"),
        ("data:nothing", "asset/parse-error"),
        ("data:,short", "asset/truncated"),
        ("x" * 5000, "asset/missing-dependency"),
        ("http://[::1", "asset/missing-dependency"),
    ],
)
def test_buffers_that_cannot_be_had(tmp_path, uri, code):
    diagnostic = refused(tmp_path, tetrahedron().gltf(uri), "part.gltf")
    assert diagnostic.code == code
    assert diagnostic.where.file == "part.gltf"


# Types.


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("/accessors/0/count", "4"),
        ("/accessors/0/count", -1),
        ("/accessors/0/count", 1.5),
        ("/accessors/0/componentType", 5124),
        ("/accessors/1/componentType", 5126),
        ("/accessors/0/bufferView", 9),
        ("/bufferViews/0/byteLength", True),
        ("/meshes/0/primitives", {}),
        ("/meshes/0/primitives/0/mode", 7),
        ("/meshes/0/primitives/0/attributes/POSITION", 99),
        ("/nodes/0/mesh", [0]),
        ("/nodes/0/rotation", [0, 0, 1]),
        ("/nodes/0/matrix", [0] * 16),
        ("/nodes/0/name", 3),
        ("/scenes/0/nodes", "0"),
        ("/scene", 4),
    ],
)
def test_wrong_types_name_their_pointer(tmp_path, path, value):
    file = tetrahedron()
    *parents, last = path.strip("/").split("/")
    target: Any = file.doc
    for key in parents:
        target = target[int(key)] if isinstance(target, list) else target[key]
    target[last] = value
    diagnostic = refused(tmp_path, file.glb())
    assert diagnostic.code == "asset/schema-error"
    assert path.startswith(diagnostic.where.prim or "?")
