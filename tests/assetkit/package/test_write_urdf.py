"""The URDF twin says the same as the USD."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest
from scipy.spatial.transform import Rotation

from assetkit.package.write_urdf import write_urdf
from schemas.physics import CollisionShape, RigidBody
from tests.support import package_samples as samples
from tests.support.present import present
from usdio.reread.body import reread_body
from usdio.write.package import write_package


def numbers(text: str | None) -> np.ndarray:
    return np.array([float(word) for word in (text or "").split()])


def read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    rows = [line.split() for line in path.read_text().splitlines()]
    points = np.array([[float(v) for v in row[1:]] for row in rows if row[0] == "v"])
    faces = np.array([[int(v.split("/")[0]) - 1 for v in row[1:]] for row in rows if row[0] == "f"])
    return points, faces


@pytest.fixture
def twin(tmp_path: Path) -> tuple[RigidBody, ElementTree.Element, Path]:
    full = samples.full_content()
    X_AS = np.eye(4)
    X_AS[:3, :3] = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    X_AS[:3, 3] = (0.01, 0.02, 0.03)
    shapes = (
        CollisionShape("box", (0.1, 0.08, 0.06), X_AS),
        CollisionShape("sphere", (0.03,), X_AS),
        CollisionShape("capsule", (0.02, 0.05), X_AS),
        CollisionShape("cylinder", (0.02, 0.07), X_AS),
        samples.hull_shape(full.model.meshes[0]),
    )
    content = samples.content(full.model, shapes)
    folder = tmp_path / content.asset_id
    body = reread_body(write_package(content, folder))
    path = write_urdf(body, content, folder)
    assert path == folder / "export" / "sample-1.urdf"
    return body, ElementTree.parse(path).getroot(), path.parent


def test_mass_inertia_and_contact_are_equal(twin: tuple[RigidBody, ElementTree.Element, Path]) -> None:
    body, robot, _ = twin
    inertial = robot.find("link/inertial")
    assert inertial is not None
    mass, origin, inertia = (inertial.find(name) for name in ("mass", "origin", "inertia"))
    assert mass is not None
    assert origin is not None
    assert inertia is not None
    assert float(mass.attrib["value"]) == body.mass.mass_kg
    assert numbers(origin.get("xyz")).tolist() == body.mass.centre_of_mass_m.tolist()
    names = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
    tensor = [[float(inertia.attrib[name]) for name in row] for row in names]
    np.testing.assert_allclose(tensor, body.mass.inertia_kgm2, rtol=0, atol=1e-18)
    friction, restitution = robot.find("link/contact/lateral_friction"), robot.find("link/contact/restitution")
    assert friction is not None
    assert restitution is not None
    assert float(friction.attrib["value"]) == body.contact.dynamic_friction
    assert float(restitution.attrib["value"]) == body.contact.restitution


def test_shapes_are_equal(twin: tuple[RigidBody, ElementTree.Element, Path]) -> None:
    body, robot, folder = twin
    collisions = robot.findall("link/collision")
    assert len(collisions) == len(body.shapes)
    for collision, shape in zip(collisions, body.shapes, strict=True):
        origin, geometry = collision.find("origin"), collision.find("geometry")
        assert origin is not None
        assert geometry is not None
        rotation = Rotation.from_euler("xyz", numbers(origin.get("rpy"))).as_matrix()
        np.testing.assert_allclose(rotation, shape.X_AS[:3, :3], atol=1e-12)
        assert numbers(origin.get("xyz")).tolist() == shape.X_AS[:3, 3].tolist()
        element = geometry[0]
        if shape.kind == "hull":
            assert shape.points is not None
            points, faces = read_obj(folder / element.attrib["filename"])
            assert np.array_equal(points, shape.points)
            assert np.array_equal(faces, present(shape.triangles))
            continue
        assert element.tag == shape.kind
        keys = {"box": ("size",), "sphere": ("radius",)}.get(shape.kind, ("radius", "length"))
        assert tuple(numbers(" ".join(element.attrib[k] for k in keys))) == shape.size_m


def test_visual_meshes_round_trip(twin: tuple[RigidBody, ElementTree.Element, Path]) -> None:
    _, robot, folder = twin
    mesh = robot.find("link/visual/geometry/mesh")
    assert mesh is not None
    points, faces = read_obj(folder / mesh.attrib["filename"])
    source = samples.full_content().model.meshes[0]
    assert np.array_equal(points, source.points)
    assert np.array_equal(faces, source.triangles)


def test_pybullet_reads_the_twin(twin: tuple[RigidBody, ElementTree.Element, Path]) -> None:
    body, _, folder = twin
    client = pybullet.connect(pybullet.DIRECT)
    try:
        file = str(folder / "sample-1.urdf")
        loaded = pybullet.loadURDF(file, flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client)
        mass, friction, diagonal, _, _, restitution, *_ = pybullet.getDynamicsInfo(loaded, -1, physicsClientId=client)
        shapes = pybullet.getCollisionShapeData(loaded, -1, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    assert mass == pytest.approx(body.mass.mass_kg, rel=1e-6)
    assert friction == pytest.approx(body.contact.dynamic_friction, rel=1e-6)
    assert restitution == pytest.approx(body.contact.restitution, rel=1e-6)
    assert sorted(diagonal) == pytest.approx(np.linalg.eigvalsh(body.mass.inertia_kgm2), rel=1e-5)
    assert len(shapes) == len(body.shapes)
