"""glTF reader: containers, accessors, primitives, nodes; what is refused, and that nothing else escapes."""

import base64
import copy
import csv
import json
import struct
import tempfile
from pathlib import Path

import DracoPy
import meshoptimizer
import numpy as np
import pytest
import trimesh
from gltf_files import FACES, POINTS, GltfFile, model, read, tetrahedron
from hypothesis import given, settings
from hypothesis import strategies as st

from assetkit.readers.gltf import read_gltf
from assetkit.source import SourceFile
from schemas.diagnostics import Diagnostic, InvalidInput, Severity
from schemas.model import Mesh
from schemas.outcome import Outcome

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "assets"
shared = pytest.mark.shared
without_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data folder is absent")


def refused(folder: Path, data: bytes, name: str = "part.glb") -> Diagnostic:
    with pytest.raises(InvalidInput) as caught:
        read(folder, data, name)
    return caught.value.diagnostic


def signed_volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", np.cross(a, b), c)) / 6.0


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
    target = file.doc
    for key in parents:
        target = target[int(key)] if isinstance(target, list) else target[key]
    target[last] = value
    diagnostic = refused(tmp_path, file.glb())
    assert diagnostic.code == "asset/schema-error"
    assert path.startswith(diagnostic.where.prim or "?")


# Accessors.


def test_accessor_past_its_view_is_refused_before_allocation(tmp_path):
    for count in (5, 4_000_000_000):
        file = tetrahedron()
        file.doc["accessors"][0]["count"] = count
        diagnostic = refused(tmp_path, file.glb())
        assert diagnostic.code == "asset/accessor-out-of-bounds"
        assert (diagnostic.value, diagnostic.bound) == (12 * count, 48)
    file = tetrahedron()
    del file.doc["accessors"][0]["bufferView"]
    file.doc["accessors"][0]["count"] = 4_000_000_000
    assert refused(tmp_path, file.glb()).code == "asset/resource-limit"
    file = tetrahedron()
    file.doc["bufferViews"][0]["byteLength"] = 10_000
    assert refused(tmp_path, file.glb()).code == "asset/accessor-out-of-bounds"


def test_strided_and_offset_accessors(tmp_path):
    file = GltfFile()
    interleaved = np.concatenate([np.full((4, 1), 9, "<f4"), POINTS, np.full((4, 1), 9, "<f4")], axis=1)
    view = file.view(interleaved.tobytes(), byteStride=20)
    file.doc["accessors"].append(
        {"bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 4, "type": "VEC3"}
    )
    file.mesh({"POSITION": 0}, indices=file.accessor(FACES.reshape(-1)))
    assert np.array_equal(model(tmp_path, file.show({"mesh": 0})).meshes[0].points, POINTS)


def test_sparse_accessors_replace_elements(tmp_path):
    file = tetrahedron()
    moved = np.array([[5, 6, 7]], dtype="<f4")
    rows = file.view(np.array([3], dtype="<u1").tobytes())
    file.doc["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": rows, "componentType": 5121},
        "values": {"bufferView": file.view(moved.tobytes())},
    }
    expected = POINTS.copy()
    expected[3] = moved
    assert np.array_equal(model(tmp_path, file).meshes[0].points, expected)
    del file.doc["accessors"][0]["bufferView"]
    expected[:3] = 0
    assert np.array_equal(model(tmp_path, file).meshes[0].points, expected)
    file.doc["accessors"][0]["count"] = 3
    assert refused(tmp_path, file.glb()).code == "asset/accessor-out-of-bounds"


@pytest.mark.parametrize(("dtype", "low"), [("<i1", -127), ("<u1", 0), ("<i2", -32767), ("<u2", 0)])
def test_normalised_and_quantised_positions(tmp_path, dtype, low):
    high = np.iinfo(dtype).max
    corners = np.where(POINTS > 0, high, low).astype(dtype)
    for normalized in (True, False):
        file = GltfFile()
        file.mesh({"POSITION": file.accessor(corners, normalized=normalized)}, indices=file.accessor(FACES.reshape(-1)))
        points = model(tmp_path, file.show({"mesh": 0})).meshes[0].points
        divisor = high if normalized else 1
        np.testing.assert_allclose([points.min(), points.max()], [low / divisor, high / divisor], rtol=1e-6)


def test_the_most_negative_normalised_integer_is_minus_one(tmp_path):
    file = GltfFile()
    file.mesh({"POSITION": file.accessor(np.array([[-128, 0, 0], [0, 127, 0], [0, 0, 1]], "<i1"), normalized=True)})
    assert model(tmp_path, file.show({"mesh": 0})).meshes[0].points.min() == -1.0


# Compression.


def test_draco(tmp_path):
    data = DracoPy.encode(POINTS.astype(np.float64), FACES.astype(np.uint32), quantization_bits=14)
    file = GltfFile()
    packed = {"bufferView": file.view(data), "attributes": {"POSITION": 0}}
    file.doc["accessors"] = [
        {"componentType": 5126, "count": 4, "type": "VEC3"},
        {"componentType": 5123, "count": 12, "type": "SCALAR"},
    ]
    file.mesh({"POSITION": 0}, indices=1, extensions={"KHR_draco_mesh_compression": packed})
    mesh = model(tmp_path, file.show({"mesh": 0})).meshes[0]
    assert len(mesh.triangles) == 4
    assert signed_volume(mesh) == pytest.approx(1 / 6, rel=1e-3)
    packed["attributes"] = {"POSITION": 7}
    assert refused(tmp_path, file.glb()).code == "asset/schema-error"
    file.doc["bufferViews"][0]["byteLength"] //= 2
    assert refused(tmp_path, file.glb()).code == "asset/parse-error"


@pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
@pytest.mark.parametrize("dtype", ["<u2", "<u4"])
def test_meshopt(tmp_path, dtype, mode):
    indices = FACES.reshape(-1).astype("<u4")
    encode = meshoptimizer.encode_index_buffer if mode == "TRIANGLES" else meshoptimizer.encode_index_sequence
    file = GltfFile()
    for data, count, stride, how in (
        (meshoptimizer.encode_vertex_buffer(POINTS, 4, 12), 4, 12, "ATTRIBUTES"),
        (encode(indices, 12, 4), 12, np.dtype(dtype).itemsize, mode),
    ):
        view = file.view(bytes(data))
        packed = {**file.doc["bufferViews"][view], "count": count, "byteStride": stride, "mode": how}
        file.doc["bufferViews"][view] = {
            "buffer": 1,
            "byteLength": count * stride,
            "extensions": {"EXT_meshopt_compression": packed},
        }
    file.doc["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123 if dtype == "<u2" else 5125, "count": 12, "type": "SCALAR"},
    ]
    file.doc["buffers"] = [{"byteLength": len(file.blob)}, {"byteLength": 999}]
    file.mesh({"POSITION": 0}, indices=1)
    mesh = model(tmp_path, file.show({"mesh": 0})).meshes[0]
    assert np.array_equal(mesh.points, POINTS)
    assert signed_volume(mesh) == pytest.approx(1 / 6)
    file.doc["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = 2**40
    assert refused(tmp_path, file.glb()).code == "asset/resource-limit"
    file.doc["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(count=4, byteStride=13)
    assert refused(tmp_path, file.glb()).code == "asset/schema-error"
    file.doc["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(byteStride=12, byteLength=9)
    assert refused(tmp_path, file.glb()).code == "asset/parse-error"


def test_meshopt_exponential_filter(tmp_path):
    mantissas = (POINTS * 8).astype(np.int32)  # value = mantissa * 2^-3
    packed_words = (np.uint32(0xFD) << np.uint32(24)) | (mantissas.view(np.uint32) & np.uint32(0xFFFFFF))
    file = GltfFile()
    view = file.view(bytes(meshoptimizer.encode_vertex_buffer(packed_words.view("<f4"), 4, 12)))
    packed = {"count": 4, "byteStride": 12, "mode": "ATTRIBUTES", "filter": "EXPONENTIAL"}
    file.doc["bufferViews"][view]["extensions"] = {
        "EXT_meshopt_compression": {**file.doc["bufferViews"][view], **packed}
    }
    file.doc["accessors"] = [{"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"}]
    file.mesh({"POSITION": 0}, indices=file.accessor(FACES.reshape(-1)))
    assert np.array_equal(model(tmp_path, file.show({"mesh": 0})).meshes[0].points, POINTS)


# Primitives.


@pytest.mark.parametrize(
    ("mode", "indices", "faces"),
    [
        (4, [0, 1, 2, 2, 1, 3], [[0, 1, 2], [2, 1, 3]]),
        (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
        (5, [0, 1, 2, 2, 3, 3, 1, 0], [[0, 1, 2], [3, 0, 1]]),
        (6, [0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]),
    ],
)
def test_primitive_modes(tmp_path, mode, indices, faces):
    file = GltfFile()
    file.mesh({"POSITION": file.accessor(POINTS)}, mode=mode, indices=file.accessor(np.array(indices, "<u1")))
    mesh = model(tmp_path, file.show({"mesh": 0})).meshes[0]
    assert mesh.triangles.tolist() == faces
    assert mesh.triangles.dtype == np.int32


def test_without_indices_vertices_come_in_order(tmp_path):
    file = GltfFile()
    file.mesh({"POSITION": file.accessor(POINTS[FACES.reshape(-1)])})
    assert signed_volume(model(tmp_path, file.show({"mesh": 0})).meshes[0]) == pytest.approx(1 / 6)


def test_no_faces_and_no_geometry_differ(tmp_path):
    file = GltfFile()
    file.mesh({"POSITION": file.accessor(POINTS)}, mode=0)
    assert refused(tmp_path, file.show({"mesh": 0}).glb()).code == "asset/no-faces"
    assert refused(tmp_path, GltfFile().glb()).code == "asset/empty-geometry"
    assert refused(tmp_path, tetrahedron().show({"name": "alone"}).glb()).code == "asset/empty-geometry"


def test_few_stray_faces_are_dropped_many_reject(tmp_path):
    indices = np.tile(FACES.reshape(-1), 5)
    indices[0] = 200
    file = GltfFile()
    file.mesh({"POSITION": file.accessor(POINTS)}, indices=file.accessor(indices))
    outcome = read(tmp_path, file.show({"mesh": 0}).glb())
    assert outcome.value is not None
    assert outcome.value.triangle_count == 19
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/index-out-of-range", Severity.WARNING)]
    (repair,) = outcome.repairs
    assert (repair.name, repair.stage) == ("index_out_of_range", "intake")
    assert (repair.before["faces"], repair.after["faces"]) == (20, 19)
    file.blob[-len(indices) * 2 :] = np.full(len(indices), 200, "<u2").tobytes()
    diagnostic = refused(tmp_path, file.glb())
    assert (diagnostic.code, diagnostic.severity) == ("asset/index-out-of-range", Severity.ERROR)


def test_non_finite_positions_name_mesh_and_vertex(tmp_path):
    file = tetrahedron()
    file.doc["meshes"][0]["name"] = "handle"
    file.blob[12 * 2 : 12 * 2 + 4] = struct.pack("<f", float("nan"))
    diagnostic = refused(tmp_path, file.glb())
    assert diagnostic.code == "asset/nonfinite-vertices"
    assert diagnostic.where.mesh == "handle"
    assert "vertex 2 of mesh 'handle'" in diagnostic.headline


def test_vertices_no_face_uses_are_left_out(tmp_path):
    file = GltfFile()
    far = np.concatenate([[[np.nan, 9, 9]], POINTS, [[99, 99, 99]]]).astype("<f4")
    file.mesh({"POSITION": file.accessor(far)}, indices=file.accessor(FACES.reshape(-1) + 1))
    assert np.array_equal(model(tmp_path, file.show({"mesh": 0})).meshes[0].points, POINTS)


def test_corner_attributes(tmp_path):
    uv = np.random.default_rng(1).random((4, 2)).astype("<f4")
    rgb = np.array([[0, 51, 255], [255, 0, 0], [0, 0, 0], [102, 102, 102]], "<u1")
    normals = POINTS / np.maximum(np.linalg.norm(POINTS, axis=1, keepdims=True), 1)
    normals[0] = [0, 0, -1]
    file = GltfFile()
    attributes = {
        "POSITION": file.accessor(POINTS),
        "NORMAL": file.accessor(normals.astype("<f4")),
        "TEXCOORD_0": file.accessor(uv),
        "TEXCOORD_1": file.accessor((uv * 255).astype("<u1"), normalized=True),
        "COLOR_0": file.accessor(rgb, normalized=True),
    }
    file.mesh(attributes, indices=file.accessor(FACES.reshape(-1)))
    mesh = model(tmp_path, file.show({"mesh": 0})).meshes[0]
    np.testing.assert_allclose(mesh.uvs[0], np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)[FACES], atol=1e-7)
    np.testing.assert_allclose(mesh.uvs[1], mesh.uvs[0], atol=1 / 254)
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, normals[FACES], atol=1e-6)
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors[..., :3], (rgb / 255.0)[FACES], atol=1e-6)
    assert (mesh.colors[..., 3] == 1.0).all()


@pytest.mark.parametrize(
    ("name", "value", "code", "repair"),
    [
        ("NORMAL", 0.0, "asset/bad-normals", "bad_normals"),
        ("NORMAL", 5.0, "asset/bad-normals", "bad_normals"),
        ("NORMAL", np.nan, "asset/bad-normals", "bad_normals"),
        ("COLOR_0", np.inf, "asset/nonfinite-colors", "nan_vertex_color"),
    ],
)
def test_bad_attributes_are_dropped_and_noted(tmp_path, name, value, code, repair):
    values = np.tile(np.array([0, 0, 1], "<f4"), (4, 1))
    values[1] = value
    file = GltfFile()
    attributes = {"POSITION": file.accessor(POINTS), name: file.accessor(values)}
    file.mesh(attributes, indices=file.accessor(FACES.reshape(-1)))
    outcome = read(tmp_path, file.show({"mesh": 0}).glb())
    assert outcome.value is not None
    assert outcome.value.meshes[0].normals is None
    assert outcome.value.meshes[0].colors is None
    assert [d.code for d in outcome.diagnostics] == [code]
    assert [r.name for r in outcome.repairs] == [repair]


def test_attribute_counts_must_agree(tmp_path):
    file = tetrahedron()
    file.doc["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = file.accessor(POINTS[:3])
    assert refused(tmp_path, file.glb()).code == "asset/schema-error"


def test_morph_targets_take_the_default_weights(tmp_path):
    file = tetrahedron()
    shift = np.full((4, 3), 2.0, "<f4")
    file.doc["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": file.accessor(shift)}]
    assert np.array_equal(model(tmp_path, file).meshes[0].points, POINTS)
    file.doc["meshes"][0]["weights"] = [0.5]
    assert np.array_equal(model(tmp_path, file).meshes[0].points, POINTS + 1.0)
    file.doc["nodes"][0]["weights"] = [1.0]
    assert np.array_equal(model(tmp_path, file).meshes[0].points, POINTS + 2.0)


# Nodes.


def test_deep_chains_work(tmp_path):
    file = tetrahedron()
    depth = 3000
    file.doc["nodes"] = [{"translation": [0, 0.001, 0], "children": [i + 1]} for i in range(depth)]
    file.doc["nodes"].append({"mesh": 0})
    points = model(tmp_path, file).meshes[0].points
    np.testing.assert_allclose(points, POINTS + np.array([0, 0.001 * depth, 0]), atol=1e-9)


@pytest.mark.parametrize(
    "nodes",
    [
        [{"children": [1]}, {"children": [0]}],
        [{"children": [0], "mesh": 0}],
        [{"mesh": 0}, {"children": [2]}, {"children": [1]}],
        [{"children": [2]}, {"children": [2]}, {"mesh": 0}],
        [{"children": [1, 1]}, {"mesh": 0}],
    ],
)
def test_cycles_and_several_parents(tmp_path, nodes):
    file = tetrahedron()
    file.doc["nodes"] = nodes
    assert refused(tmp_path, file.glb()).code == "asset/cyclic-reference"


def test_scene_selection(tmp_path):
    file = tetrahedron()
    file.doc["nodes"] = [{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b"}, {"mesh": 0, "name": "c"}]
    file.doc["scenes"] = [{"nodes": [0]}, {"nodes": [2, 1]}]
    del file.doc["scene"]

    def shown() -> list[str]:
        return [node.path for node in model(tmp_path, file).nodes]

    assert shown() == ["/a", "/b", "/c"]
    file.doc["scene"] = 1
    assert shown() == ["/c", "/b"]
    file.doc["scenes"] = file.doc["scenes"][:1]
    del file.doc["scene"]
    assert shown() == ["/a"]


def test_awkward_names_and_hierarchy(tmp_path):
    file = tetrahedron()
    file.doc["meshes"][0]["name"] = "Küche #2"
    file.show({"name": "stuhl bein", "mesh": 0, "translation": [1, 0, 0]}, {"name": "stuhl bein", "mesh": 0}, {})
    value = read(tmp_path, file.glb(), "Küchen stuhl #2.glb").value
    assert value is not None
    assert [m.name for m in value.meshes] == ["Küche #2"] * 2
    assert value.meshes[0].source_path == "/stuhl bein/Küche #2"
    assert [(n.path, n.meshes) for n in value.nodes] == [("/stuhl bein", (0,)), ("/stuhl bein", (1,)), ("/node_3", ())]
    assert value.nodes[0].X_PN[:3, 3].tolist() == [1, 0, 0]


finite = st.floats(-2, 2).map(lambda x: round(x, 3))


@settings(max_examples=60, deadline=None)
@given(st.lists(finite, min_size=9, max_size=9), st.lists(finite, min_size=3, max_size=3))
def test_any_affine_node_keeps_faces_and_normals_outward(entries, shift):
    linear = np.array(entries).reshape(3, 3)
    determinant = np.linalg.det(linear)
    if abs(determinant) < 0.05:
        return
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = linear, shift
    solid = trimesh.creation.icosphere(subdivisions=1)
    file = GltfFile()
    attributes = {
        "POSITION": file.accessor(solid.vertices.astype("<f4")),
        "NORMAL": file.accessor(solid.vertices.astype("<f4")),
        "TEXCOORD_0": file.accessor(solid.vertices[:, :2].astype("<f4")),
    }
    file.mesh(attributes, indices=file.accessor(solid.faces.reshape(-1).astype("<u2")))
    file.show({"mesh": 0, "matrix": X.T.reshape(-1).tolist()})
    with tempfile.TemporaryDirectory() as folder:
        mesh = model(Path(folder), file).meshes[0]
    assert signed_volume(mesh) == pytest.approx(abs(determinant) * solid.volume, rel=1e-4)
    assert mesh.normals is not None
    # The normal of an ellipsoid at M p is parallel to M^-T p; uvs still belong to their points.
    corners = mesh.points[mesh.triangles]
    source = (corners - shift) @ np.linalg.inv(linear).T
    expected = source @ np.linalg.inv(linear)
    expected /= np.linalg.norm(expected, axis=2, keepdims=True)
    np.testing.assert_allclose(mesh.normals, expected, atol=1e-3)
    np.testing.assert_allclose(mesh.uvs[0], source[..., :2] * [1, -1] + [0, 1], atol=1e-3)


def test_translation_rotation_scale_equal_their_matrix(tmp_path):
    file = tetrahedron()
    half = np.sqrt(0.5)  # A quarter turn about z.
    file.doc["nodes"][0].update(translation=[1, 2, 3], rotation=[0, 0, half, half], scale=[2, 3, 4])
    expected = POINTS * [2, 3, 4] @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).T + [1, 2, 3]
    np.testing.assert_allclose(model(tmp_path, file).meshes[0].points, expected, atol=1e-12)


def test_a_flattening_node_has_no_crash(tmp_path):
    file = tetrahedron()
    file.doc["nodes"][0]["scale"] = [0, 0, 0]
    assert np.ptp(model(tmp_path, file).meshes[0].points) == 0.0


def test_instances_are_limited(tmp_path, monkeypatch):
    monkeypatch.setattr("assetkit.readers.gltf_geometry.MAX_TRIANGLES", 10)
    assert refused(tmp_path, tetrahedron().show(*[{"mesh": 0}] * 3).glb()).code == "asset/resource-limit"


# The rest of the model.


def test_evidence_hints_and_metadata(tmp_path):
    file = tetrahedron()
    file.doc["asset"].update(
        generator="Blender", copyright="2024 A", extras={"author": "Ann", "license": "CC0", "views": 3}
    )
    file.doc["nodes"][0]["name"] = "mug_mm"
    file.doc["animations"] = [{"channels": [], "samplers": []}]
    outcome = read(tmp_path, file.glb())
    value = outcome.value
    assert value is not None
    assert (value.meters_per_unit.value, value.meters_per_unit.source) == (1.0, "declared")
    assert (value.up_axis.value, value.up_axis.source) == ("y", "declared")
    assert {"Blender", "2024 A", "mug_mm"} <= set(value.hints)
    assert value.metadata == {"author": "Ann", "copyright": "2024 A", "generator": "Blender", "license": "CC0"}
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/animation-dropped", Severity.INFO)]


# Nothing else escapes.


def rich_file() -> GltfFile:
    file = tetrahedron()
    uv = file.accessor(POINTS[:, :2].copy(), sparse={"count": 0, "indices": {"bufferView": 0, "componentType": 5121},
                                                     "values": {"bufferView": 0}})  # fmt: skip
    primitive = file.doc["meshes"][0]["primitives"][0]
    primitive["attributes"]["TEXCOORD_0"] = uv
    primitive["material"] = 0
    file.doc["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(b"\x89PNG").decode()}]
    file.doc["samplers"] = [{"wrapS": 33071}]
    file.doc["textures"] = [{"source": 0, "sampler": 0}]
    texture = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1}}}
    file.doc["materials"] = [
        {
            "name": "m",
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": texture, "metallicFactor": 0},
            "normalTexture": {"index": 0, "scale": 1},
            "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_clearcoat": {"clearcoatFactor": 1}},
        }
    ]
    file.doc["nodes"] = [{"children": [1], "translation": [0, 0, 0]}, {"mesh": 0, "name": "n", "scale": [1, 1, 1]}]
    return file


def leaves(value: object, path: tuple = ()) -> list[tuple]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(leaf for key, child in pairs for leaf in leaves(child, (*path, key)))]


def test_any_wrong_value_anywhere_is_an_outcome_or_a_finding(tmp_path):
    original = rich_file()
    assert read(tmp_path, original.glb()).value is not None
    places = leaves(original.doc)[1:]
    assert len(places) > 100
    for path in places:
        for value in (None, "x", [], {}, [None], -1, 0.5, 1e300, 10**30, True, 2**31):
            file = GltfFile()
            file.doc, file.blob = copy.deepcopy(original.doc), original.blob
            target = file.doc
            for key in path[:-1]:
                target = target[key]
            target[path[-1]] = value
            try:
                assert isinstance(read(tmp_path, file.gltf(), "part.gltf"), Outcome)
            except InvalidInput:
                continue


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=5), st.integers(0, 4000))
def test_any_damaged_glb_is_an_outcome_or_a_finding(edits, length):
    data = bytearray(rich_file().glb())
    for position, value in edits:
        data[position % len(data)] = value
    with tempfile.TemporaryDirectory() as folder:
        try:
            assert isinstance(read(Path(folder), bytes(data[:length])), Outcome)
        except InvalidInput as error:
            json.dumps(error.diagnostic.model_dump())


# Real files.


def rows() -> list[dict[str, str]]:
    if not SHARED.is_dir():
        return []
    with (SHARED / "manifest.csv").open(newline="") as file:
        return [row for row in csv.DictReader(file) if row["path"].endswith((".glb", ".gltf"))]


def asset_root(path: str) -> Path:
    parts = Path(path).parts
    return SHARED.joinpath(*parts[: 3 if parts[0] == "malformed" else 2])


@shared
@without_shared
@pytest.mark.parametrize("row", [r for r in rows() if r["outcome"] == "reject"], ids=lambda r: r["id"])
def test_bad_files_are_refused_for_their_reason(row):
    with pytest.raises(InvalidInput) as caught:
        read_gltf(SourceFile(SHARED / row["path"], asset_root(row["path"])))
    assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-")


@shared
@without_shared
@pytest.mark.parametrize("row", [r for r in rows() if r["outcome"] != "reject"], ids=lambda r: r["id"])
def test_good_files_agree_with_an_independent_reader(row):
    path = SHARED / row["path"]
    outcome = read_gltf(SourceFile(path, asset_root(row["path"])))
    assert not outcome.failed
    assert outcome.value is not None
    assert bool(outcome.repairs) == (row["outcome"] == "repair")
    points = np.concatenate([m.points for m in outcome.value.meshes])
    document = _document(path)
    sparse = any("sparse" in accessor for accessor in document["accessors"])  # trimesh ignores sparse values.
    if row["measured_extent_native"] and not sparse:
        measured = [float(x) for x in row["measured_extent_native"].split("x")]
        np.testing.assert_allclose(np.ptp(points, axis=0), measured, rtol=1e-4, atol=1e-5)
    if sparse or row["outcome"] == "repair" or document.get("extensionsRequired") or len(document["nodes"]) > 100:
        pytest.skip("trimesh does not decode, stumbles over or takes 12 s for it")
    reference = trimesh.load_scene(path).to_mesh()
    assert outcome.value.triangle_count == len(reference.faces)
    np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], reference.bounds, rtol=1e-5, atol=1e-6)
    mine = trimesh.Trimesh(points, _all_triangles(outcome.value.meshes), process=False)
    assert mine.area == pytest.approx(reference.area, rel=1e-4)
    assert mine.volume == pytest.approx(reference.volume, rel=1e-3, abs=1e-7)


def _document(path: Path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]] if data.startswith(b"glTF") else data)


def _all_triangles(meshes: tuple[Mesh, ...]) -> np.ndarray:
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    return np.concatenate([m.triangles + start for m, start in zip(meshes, starts, strict=False)])
