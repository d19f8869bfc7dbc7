"""glTF accessors: bounds, strides, sparse parts, normalised integers, Draco and meshopt data."""

import DracoPy
import meshoptimizer
import numpy as np
import pytest

from tests.support.gltf_files import FACES, POINTS, GltfFile, model, refused, signed_volume, tetrahedron

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
