"""glTF primitives: drawing modes, corner attributes, stray faces, morph targets."""

import struct

import numpy as np
import pytest

from schemas.diagnostics import Severity
from tests.support.gltf_files import FACES, POINTS, GltfFile, model, read, refused, signed_volume, tetrahedron


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


def test_points_beside_triangles_are_left_out_with_a_word(tmp_path):
    file = tetrahedron()
    primitives = file.doc["meshes"][0]["primitives"]
    primitives.append({"attributes": primitives[0]["attributes"], "mode": 0})
    found = read(tmp_path, file.glb()).diagnostics
    assert [(d.code, d.severity) for d in found] == [("asset/geometry-left-out", "info")]
