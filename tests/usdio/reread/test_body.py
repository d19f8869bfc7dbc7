"""Bodies, contacts and surfaces re-read from a written package equal its content."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape, Contact, MassProperties
from tests.support import package_samples as samples
from usdio.reread.body import reread_body, reread_visual
from usdio.write.package import write_package


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 10_000),
    masses=st.sampled_from([(1.0, 1.0, 1.0), (1.0, 1.0, 3.0), (1.0, 5.0, 5.0), (2.0, 3.0, 4.0)]),
    size_m=st.sampled_from([1e-3, 0.1, 400.0]),
)
def test_mass_properties_come_back(tmp_path: Path, seed: int, masses: tuple[float, ...], size_m: float) -> None:
    rng = np.random.default_rng(seed)
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    # Three pairs of point masses on the principal axes: a real body by construction.
    spread = np.array(masses) * size_m**2
    inertia = R @ np.diag(spread.sum() - spread) @ R.T
    mass = MassProperties(float(rng.uniform(1e-6, 1e4)), rng.normal(size=3) * size_m, inertia)
    content = replace(samples.content(samples.model([samples.box_mesh()])), mass=mass)
    body = reread_body(write_package(content, tmp_path / content.asset_id))
    assert body.mass.mass_kg == pytest.approx(mass.mass_kg, rel=1e-6)
    np.testing.assert_allclose(body.mass.centre_of_mass_m, mass.centre_of_mass_m, rtol=1e-6)
    np.testing.assert_allclose(body.mass.inertia_kgm2, inertia, atol=1e-6 * np.abs(inertia).max())


def test_shapes_and_contact_come_back(tmp_path: Path) -> None:
    X_AS = np.eye(4)
    X_AS[:3, :3] = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    X_AS[:3, 3] = (0.01, 0.02, 0.03)
    mesh = samples.box_mesh()
    shapes = (
        CollisionShape("box", (0.1, 0.2, 0.3), X_AS),
        CollisionShape("sphere", (0.03,), X_AS),
        CollisionShape("capsule", (0.02, 0.05), X_AS),
        CollisionShape("cylinder", (0.02, 0.07), X_AS),
        samples.hull_shape(mesh),
    )
    contact = Contact(static_friction=0.6, dynamic_friction=0.45, restitution=0.2, combine="multiply")
    content = samples.content(samples.model([mesh]), shapes, contact=contact)
    body = reread_body(write_package(content, tmp_path / content.asset_id))
    assert [shape.kind for shape in body.shapes] == [shape.kind for shape in shapes]
    for reread, given_ in zip(body.shapes, shapes, strict=True):
        assert reread.size_m == pytest.approx(given_.size_m, rel=1e-12)
        np.testing.assert_allclose(reread.X_AS, given_.X_AS, atol=1e-12)
    hull = body.shapes[-1]
    assert shapes[-1].points is not None
    assert hull.points is not None
    np.testing.assert_allclose(hull.points, shapes[-1].points, atol=1e-7)
    assert body.contact.combine == "multiply"
    assert body.contact.dynamic_friction == pytest.approx(0.45)
    assert body.contact.restitution == pytest.approx(0.2)


def test_visible_surface_is_merged_in_order(tmp_path: Path) -> None:
    meshes = [samples.box_mesh(), samples.box_mesh((0.02, 0.02, 0.02), "knob", (0.0, 0.0, 0.06))]
    content = samples.content(samples.model(meshes))
    points, triangles = reread_visual(write_package(content, tmp_path / content.asset_id))
    np.testing.assert_allclose(points, np.concatenate([m.points for m in meshes]), atol=1e-8)
    assert np.array_equal(triangles, np.concatenate([meshes[0].triangles, meshes[1].triangles + 8]))


def test_a_rewritten_file_is_read_anew(tmp_path: Path) -> None:
    content = samples.content(samples.model([samples.box_mesh()]))
    main_file = write_package(content, tmp_path / content.asset_id)
    first = reread_body(main_file)
    write_package(replace(content, mass=replace(content.mass, mass_kg=7.0)), tmp_path / content.asset_id)
    assert (first.mass.mass_kg != 7.0, reread_body(main_file).mass.mass_kg) == (True, 7.0)


def test_a_file_without_body_is_a_finding(tmp_path: Path) -> None:
    file = tmp_path / "none.usda"
    for text in ('#usda 1.0\ndef Xform "a" {}\n', "no usd at all"):
        file.write_text(text)
        with pytest.raises(InvalidInput) as caught:
            reread_body(file)
        assert caught.value.diagnostic.code == "asset/package-invalid"
