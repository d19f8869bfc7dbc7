"""Skins in their stored pose, and instancing: laws that hold for any joint and any copy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.gltf_files import POINTS, GltfFile, model, read, refused, signed_volume, tetrahedron

TURN = Rotation.from_euler("xyz", [0.3, -0.7, 1.1])
PLACED = {"translation": [1.0, 2.0, 3.0], "rotation": list(TURN.as_quat()), "scale": [2.0, 2.0, 2.0]}
X_MJ = np.block([[2.0 * TURN.as_matrix(), np.array([[1.0], [2.0], [3.0]])], [np.zeros(3), np.ones(1)]])


def moved(points: np.ndarray, X: np.ndarray) -> np.ndarray:
    return points @ X[:3, :3].T + X[:3, 3]


def skinned(joints: list, weights: list, *nodes: dict, bind: np.ndarray | None = None) -> GltfFile:
    """A tetrahedron whose node 0 is scaled by 100 (which must not count) and follows `nodes`, numbered from 1."""
    file = GltfFile()
    attributes = {
        "POSITION": file.accessor(POINTS),
        "JOINTS_0": file.accessor(np.array(joints, dtype="<u1")),
        "WEIGHTS_0": file.accessor(np.array(weights, dtype="<f4")),
    }
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype="<u2")
    file.mesh(attributes, indices=file.accessor(faces.reshape(-1)))
    skin: dict = {"joints": list(range(1, len(nodes) + 1))}
    if bind is not None:
        columns = bind.transpose(0, 2, 1).reshape(-1, 16).astype("<f4")
        view = file.view(columns.tobytes())
        file.doc["accessors"].append({"bufferView": view, "componentType": 5126, "count": len(bind), "type": "MAT4"})
        skin["inverseBindMatrices"] = len(file.doc["accessors"]) - 1
    file.doc["skins"] = [skin]
    return file.show({"mesh": 0, "skin": 0, "scale": [100, 100, 100]}, *nodes)


FIRST = [[0, 0, 0, 0]] * 4
WHOLE = [[1.0, 0, 0, 0]] * 4


def test_a_vertex_stands_where_its_joint_holds_it_and_the_node_does_not_count(tmp_path):
    mesh = model(tmp_path, skinned(FIRST, WHOLE, PLACED)).meshes[0]
    np.testing.assert_allclose(mesh.points, moved(POINTS, X_MJ), atol=1e-6)
    assert signed_volume(mesh) == pytest.approx(8 / 6)


def test_in_the_bind_pose_the_mesh_is_as_stored(tmp_path):
    file = skinned(FIRST, WHOLE, PLACED, bind=np.linalg.inv(X_MJ)[None])
    np.testing.assert_allclose(model(tmp_path, file).meshes[0].points, POINTS, atol=1e-6)


def test_weights_blend_and_need_not_sum_to_one(tmp_path):
    right, up = {"translation": [1.0, 0, 0]}, {"translation": [0, 1.0, 0]}
    file = skinned([[0, 1, 0, 0]] * 4, [[0.5, 0.5, 0, 0], [3, 1, 0, 0], [0, 0, 0, 0], [0, 2, 0, 0]], right, up)
    shift = [[0.5, 0.5, 0], [0.75, 0.25, 0], [1, 0, 0], [0, 1, 0]]  # no weight at all: the first joint
    np.testing.assert_allclose(model(tmp_path, file).meshes[0].points, POINTS + shift, atol=1e-6)


def test_mirroring_joints_keep_the_outside_outside(tmp_path):
    mesh = model(tmp_path, skinned(FIRST, WHOLE, {"scale": [-1, 1, 1]})).meshes[0]
    assert signed_volume(mesh) == pytest.approx(1 / 6)


def test_a_stored_pose_is_announced(tmp_path):
    outcome = read(tmp_path, skinned(FIRST, WHOLE, PLACED).glb())
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/animation-dropped", "info")]
    assert "skin" in outcome.diagnostics[0].headline


@pytest.mark.parametrize(
    ("file", "code"),
    [
        (skinned([[7, 0, 0, 0]] * 4, WHOLE, PLACED), "asset/schema-error"),
        (skinned(FIRST, WHOLE, PLACED, bind=np.zeros((0, 4, 4))), "asset/schema-error"),
        (skinned(FIRST, WHOLE, {"scale": [1e308, 1, 1], "translation": [1e308, 0, 0]}), "asset/nonfinite-vertices"),
    ],
)
def test_skins_that_cannot_be(tmp_path, file: GltfFile, code: str):
    assert refused(tmp_path, file.glb()).code == code


def test_a_joint_without_weight_may_be_any(tmp_path):
    file = skinned([[0, 9, 9, 9]] * 4, WHOLE, {})
    np.testing.assert_allclose(model(tmp_path, file).meshes[0].points, POINTS, atol=1e-6)


def instanced(**attributes: np.ndarray) -> GltfFile:
    file = tetrahedron()
    named = {name: file.accessor(values.astype("<f4")) for name, values in attributes.items()}
    file.doc["nodes"][0] |= {
        "translation": [0, 0, 5],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": named}},
    }
    file.doc["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    return file


def test_every_copy_is_drawn_in_the_frame_of_its_node(tmp_path):
    shifts = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
    quats = np.array([[0.0, 0, 0, 1], TURN.as_quat(), [0, 0, 0, 0]])
    scales = np.array([[1.0, 1, 1], [2, 2, 2], [1, 1, -1]])
    meshes = model(tmp_path, instanced(TRANSLATION=shifts, ROTATION=quats, SCALE=scales)).meshes
    turns = [np.eye(3), TURN.as_matrix(), np.eye(3)]
    for mesh, shift, R, scale in zip(meshes, shifts, turns, scales, strict=True):
        expected = (POINTS * scale) @ R.T + shift + [0, 0, 5]
        np.testing.assert_allclose(mesh.points, expected, atol=1e-6)
        assert signed_volume(mesh) > 0
    assert len({m.name for m in meshes}) == 3


@pytest.mark.parametrize(
    ("attributes", "code"),
    [
        ({}, "asset/schema-error"),
        ({"TRANSLATION": np.zeros((2, 3)), "SCALE": np.ones((3, 3))}, "asset/schema-error"),
        ({"TRANSLATION": np.zeros((2, 4))}, "asset/schema-error"),
        ({"TRANSLATION": np.zeros((1001, 3))}, "asset/resource-limit"),
        ({"TRANSLATION": np.full((2, 3), np.nan)}, "asset/nonfinite-vertices"),
    ],
)
def test_instances_that_cannot_be(tmp_path, attributes: dict, code: str):
    assert refused(tmp_path, instanced(**attributes).glb()).code == code
