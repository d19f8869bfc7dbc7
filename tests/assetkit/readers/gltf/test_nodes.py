"""The glTF hierarchy: transforms, mirroring, scene selection, cycles and depth."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.gltf_files import POINTS, GltfFile, model, read, refused, signed_volume, tetrahedron


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
    monkeypatch.setattr("assetkit.readers.gltf.geometry.MAX_TRIANGLES", 10)
    assert refused(tmp_path, tetrahedron().show(*[{"mesh": 0}] * 3).glb()).code == "asset/resource-limit"
