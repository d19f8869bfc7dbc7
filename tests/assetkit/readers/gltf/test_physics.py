"""What a glTF file states about mass and friction (KHR_physics_rigid_bodies, OMI_physics_body)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from geom.mass.principal_axes import principal_axes
from tests.support.gltf_files import GltfFile, model, read, refused, tetrahedron
from tests.support.present import present

TURN_XYZW = Rotation.from_rotvec([0.4, -0.2, 0.9]).as_quat().tolist()
AXES_XYZW = Rotation.from_rotvec([0.1, 0.5, -0.3]).as_quat().tolist()


def body(name: str = "KHR_physics_rigid_bodies", **motion: Any) -> dict[str, Any]:
    return {"extensions": {name: {"motion": motion}}}


def moving(**motion: Any) -> GltfFile:
    file = tetrahedron()
    file.doc["nodes"][0] |= body(**motion)
    return file


def test_mass_centre_and_tensor_go_through_the_node(tmp_path):
    file = tetrahedron()
    file.doc["nodes"] = [
        {"children": [1], "translation": [1, 2, 3], "scale": [2, 2, 2]},
        {
            "mesh": 0,
            "rotation": TURN_XYZW,
            **body(mass=3.0, centerOfMass=[0.2, 0.1, 0], inertiaDiagonal=[1, 2, 2.5], inertiaOrientation=AXES_XYZW),
        },
    ]
    (stated,) = model(tmp_path, file).masses
    R_WN, R_NP = Rotation.from_quat(TURN_XYZW).as_matrix(), Rotation.from_quat(AXES_XYZW).as_matrix()
    assert stated.mass_kg == 3.0
    assert stated.triangles == 4
    assert_allclose(present(stated.centre), np.array([1, 2, 3]) + 2 * R_WN @ [0.2, 0.1, 0], atol=1e-12)
    assert_allclose(present(stated.inertia), R_WN @ R_NP @ np.diag([1, 2, 2.5]) @ R_NP.T @ R_WN.T, atol=1e-12)


def test_what_is_left_to_the_engine_is_not_stated(tmp_path):
    assert model(tmp_path, moving()).masses == ()
    assert model(tmp_path, moving(mass=0)).masses == ()  # Infinite.
    (stated,) = model(tmp_path, moving(mass=1, inertiaDiagonal=[1, 0, 1])).masses
    assert (stated.centre, stated.inertia) == (None, None)


@pytest.mark.parametrize(
    "extension",
    [
        {"motion": {"type": "dynamic", "mass": 2.0, "inertiaDiagonal": [0.1, 0.2, 0.25]}},
        {"type": "rigid", "mass": 2.0, "inertiaTensor": [0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.25]},
    ],
    ids=["second draft", "first draft"],
)
def test_omi_bodies_are_read(tmp_path, extension):
    file = tetrahedron()
    file.doc["nodes"][0]["extensions"] = {"OMI_physics_body": extension}
    file.doc |= {"extensionsUsed": ["OMI_physics_body"], "extensionsRequired": ["OMI_physics_body"]}
    (stated,) = model(tmp_path, file).masses
    assert (stated.method, stated.mass_kg) == ("OMI_physics_body", 2.0)
    assert_allclose(principal_axes(present(stated.inertia))[0], [0.1, 0.2, 0.25])


def test_a_body_moves_what_hangs_on_it_except_other_bodies(tmp_path):
    file = tetrahedron()
    file.doc["nodes"] = [
        {"name": "cart", "mesh": 0, "children": [1, 2], **body(mass=5)},
        {"name": "seat", "mesh": 0, "translation": [2, 0, 0]},
        {"name": "wheel", "mesh": 0, "translation": [0, 2, 0], **body(mass=1)},
    ]
    covers = {stated.mass_kg: stated.covers for stated in model(tmp_path, file).masses}
    assert covers == {5.0: ("/cart/mesh_0", "/cart/seat/mesh_0"), 1.0: ("/cart/wheel/mesh_0",)}


def test_contact_materials_of_colliders_reach_the_meshes_of_their_body(tmp_path):
    file = tetrahedron()
    collider = {"collider": {"geometry": {"shape": 0}, "physicsMaterial": 0}}
    file.doc["nodes"] = [
        {"name": "ball", "mesh": 0, "children": [1], **body(mass=1)},
        {"name": "shape", "extensions": {"KHR_physics_rigid_bodies": collider}},
    ]
    stated = {"name": "felt", "staticFriction": 0.8, "restitution": 0.1, "frictionCombine": "maximum"}
    file.doc["extensions"] = {"KHR_physics_rigid_bodies": {"physicsMaterials": [stated]}}
    (contact,) = model(tmp_path, file).contacts
    assert contact.covers == ("/ball/mesh_0",)
    assert (contact.static_friction, contact.dynamic_friction, contact.restitution) == (0.8, None, 0.1)
    assert (contact.name, contact.combine) == ("felt", "maximum")


def test_joints_are_reported(tmp_path):
    file = tetrahedron()
    file.doc["nodes"][0]["extensions"] = {"KHR_physics_rigid_bodies": {"joint": {"connectedNode": 0, "joint": 0}}}
    assert "asset/articulated-source" in [d.code for d in read(tmp_path, file.glb()).diagnostics]


def test_a_broken_statement_names_its_place(tmp_path):
    found = refused(tmp_path, moving(mass="heavy").glb())
    assert found.code == "asset/schema-error"
    assert "motion/mass" in (found.where.prim or "")
