"""Every collider touches as the part that it stands for, in the USD, the URDF twin and the record."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdPhysics
from scipy.spatial.transform import Rotation

from assetkit.mass.parts import MassEvidenceInputs
from assetkit.package.write_urdf import rewrite_urdf, write_urdf
from assetkit.physics.build import PhysicsResult, build_physics
from assetkit.physics.collider_materials import surface_shares
from assetkit.taxonomy.material_classes import materials
from formats.urdf.write import DRAKE
from geom.convex.support_function import surface as surface_of
from geom.solid.solidify import solidify
from schemas.evidence import inferred
from schemas.model import Mesh
from schemas.physics import Contact, SurfaceMaterial
from tests.support.package_samples import content, hull_shape, mesh_from, model
from usdio.contact_material import bound_contact_material
from usdio.reread.body import collider_prims, reread_body, reread_shape_contacts
from usdio.write.package import write_package
from usdio.write.rewrite_physics import rewrite_physics

STEEL, WOOD, RUBBER = (materials()[name] for name in ("steel", "wood", "rubber"))


def part(size, at, name: str, R_AM: Rotation | None = None, scale: float = 1.0) -> Mesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(at)
    mesh.vertices = scale * (R_AM or Rotation.identity()).apply(mesh.vertices)
    return mesh_from(mesh, name)


def hammer(R_AM: Rotation | None = None, scale: float = 1.0) -> list[Mesh]:
    head = part((0.05, 0.05, 0.05), (0.0, 0.0, 0.0), "steel head", R_AM, scale)
    handle = part((0.2, 0.02, 0.02), (0.125, 0.0, 0.0), "wooden handle", R_AM, scale)
    grip = part((0.1, 0.03, 0.03), (0.275, 0.0, 0.0), "rubber grip", R_AM, scale)
    return [head, handle, grip]


def built(meshes: list[Mesh], folder: Path, *names: str) -> PhysicsResult:
    return build_physics(
        solidify(meshes)[0], names, work_dir=folder, mass_inputs=MassEvidenceInputs(meshes=tuple(meshes))
    )


@pytest.mark.parametrize("seed", range(3))
def test_each_hull_touches_as_the_part_it_stands_for(tmp_path: Path, seed: int) -> None:
    """However the object lies, whatever its size and the order of its parts."""
    rng = np.random.default_rng(seed)
    meshes = hammer(Rotation.random(rng=rng), float(rng.choice([0.3, 1.0, 3.0])))
    physics = built([meshes[i] for i in rng.permutation(3)], tmp_path)
    assert len(physics.shape_surfaces) == len(physics.shapes) >= 3
    axis = meshes[1].points.mean(axis=0) - meshes[0].points.mean(axis=0)
    scale = np.linalg.norm(axis) / 0.125
    for shape, index in zip(physics.shapes, physics.shape_surfaces, strict=True):
        along = (
            (surface_of(shape)[0].mean(axis=0) - meshes[0].points.mean(axis=0)) @ axis / np.linalg.norm(axis) / scale
        )
        expected = STEEL if along < 0.025 else WOOD if along < 0.225 else RUBBER
        surface = physics.surfaces[index]
        assert (surface.label, surface.density_kgm3) == (expected.name, expected.density_kgm3)
        assert surface.contact.static_friction == expected.static_friction
    for row in physics.section.collider_materials:
        assert row.shares[row.material] > 0.9
    for recorded in physics.section.mass_parts:
        assert recorded.contacts[0].value.dynamic_friction == materials()[recorded.material.value].dynamic_friction


def test_a_hull_over_two_parts_says_so(tmp_path: Path) -> None:
    """Two cubes side by side make one box: half of its surface each."""
    halves = [part((0.1,) * 3, (0.0, 0.0, 0.0), "oak"), part((0.1,) * 3, (0.1, 0.0, 0.0), "steel")]
    found = built(halves, tmp_path)
    assert found.section.collision_method == "box"
    (row,) = found.section.collider_materials
    assert row.shares["steel"] == pytest.approx(0.5, abs=0.02)
    assert [d.code for d in found.diagnostics] == ["asset/mixed-collider"]


def test_what_is_buried_touches_nothing(tmp_path: Path) -> None:
    meshes = [part((0.1,) * 3, (0.0, 0.0, 0.0), "oak"), part((0.05,) * 3, (0.0, 0.0, 0.0), "steel")]
    (row,) = built(meshes, tmp_path).section.collider_materials
    assert row.shares == {"wood": 1.0, "steel": 0.0}


def test_one_material_is_as_before(tmp_path: Path) -> None:
    found = built([part((0.1,) * 3, (0.0, 0.0, 0.0), "oak")], tmp_path)
    assert (found.surfaces, found.shape_surfaces, found.section.collider_materials) == ((), (), ())


def test_shares_of_a_hull_inside_others_are_none() -> None:
    outer, inner = part((0.1,) * 3, (0.0, 0.0, 0.0), "a"), part((0.02,) * 3, (0.0, 0.0, 0.0), "b")
    shares = surface_shares([hull_shape(outer), hull_shape(inner)], solidify([outer])[0], [[outer]])
    assert shares.tolist() == [[1.0], [0.0]]


def bound(main_file: Path) -> list[tuple[str, float, float]]:
    stage = Usd.Stage.Open(str(main_file))
    materials = [bound_contact_material(prim) for prim in collider_prims(stage.GetDefaultPrim())]
    return [
        (a.GetPrim().GetName(), a.GetDensityAttr().Get(), round(a.GetDynamicFrictionAttr().Get(), 6))
        for a in materials
        if isinstance(a, UsdPhysics.MaterialAPI) and a
    ]


def test_package_and_twin_bind_shape_by_shape_also_after_a_measurement(tmp_path: Path) -> None:
    def surface(label: str, density: float, friction: float) -> SurfaceMaterial:
        touch = Contact(static_friction=friction, dynamic_friction=friction, restitution=0.1)
        return SurfaceMaterial(label, density, touch)

    meshes = hammer()
    package_content = content(
        model(meshes),
        [hull_shape(mesh) for mesh in meshes],
        surfaces=(surface("steel", 7850.0, 0.5), surface("wood", 650.0, 0.3), surface("steel", 7000.0, 0.6)),
        shape_surfaces=(1, 0, 2),
    )
    main_file = write_package(package_content, tmp_path / "sample")
    assert bound(main_file) == [("wood", 650.0, 0.3), ("steel", 7850.0, 0.5), ("steel_2", 7000.0, 0.6)]
    body = reread_body(main_file)
    assert body.contact.dynamic_friction == pytest.approx(0.5)  # Of the material written first.
    twin = write_urdf(body, package_content, tmp_path / "sample", reread_shape_contacts(main_file))
    assert frictions(twin) == pytest.approx([0.3, 0.5, 0.6])

    measured = Contact(static_friction=0.2, dynamic_friction=0.2, restitution=0.0, combine="minimum")
    rewrite_physics(main_file, package_content.mass, measured, 2.0)
    assert bound(main_file) == [("wood", 1300.0, 0.2), ("steel", 15700.0, 0.2), ("steel_2", 14000.0, 0.2)]
    rewrite_urdf(reread_body(main_file), twin, {}, reread_shape_contacts(main_file))
    assert frictions(twin) == pytest.approx([0.2, 0.2, 0.2])


def frictions(twin: Path) -> list[float]:
    """The dynamic friction of each collision of a URDF."""
    elements = ElementTree.parse(twin).iter(f"{{{DRAKE}}}mu_dynamic")
    return [float(element.attrib["value"]) for element in elements]


def test_parts_touch_as_they_look_where_no_name_tells(tmp_path: Path) -> None:
    """One mesh, its far end like rubber, the rest like steel: mass and density stay those of an unknown thing."""
    bar, grip = part((0.2, 0.02, 0.02), (0.0, 0.0, 0.0), "bar"), part((0.1, 0.04, 0.04), (0.16, 0.0, 0.0), "bar")
    mesh = mesh_from(trimesh.Trimesh(np.concatenate([bar.points, grip.points]), _both(bar, grip), process=False), "bar")
    looks = inferred("steel", "looks", 0.7), inferred("rubber", "looks", 0.6)
    of_face = np.repeat([0, 1], [len(bar.triangles), len(grip.triangles)])
    solid = solidify([mesh])[0]
    seen = build_physics(
        solid,
        [],
        work_dir=tmp_path,
        mass_inputs=MassEvidenceInputs((mesh,), surface_materials=looks, material_of_face=(of_face,)),
    )
    blind = build_physics(solid, [], work_dir=tmp_path, mass_inputs=MassEvidenceInputs((mesh,)))
    assert {s.label for s in seen.surfaces} == {"steel", "rubber"}
    assert {r.material for r in seen.section.collider_materials} == {"steel", "rubber"}
    assert seen.section.material == looks[1]  # It has most of the surface.
    assert seen.section.contacts[0].value.static_friction == RUBBER.static_friction
    assert seen.section.mass_kg == blind.section.mass_kg
    assert seen.section.mass_parts[0].material.value == "unknown"


def test_a_name_decides_against_looks(tmp_path: Path) -> None:
    mesh = part((0.1,) * 3, (0.0, 0.0, 0.0), "oak")
    mass_inputs = MassEvidenceInputs(
        (mesh,), surface_materials=(inferred("steel", "looks", 0.9),), material_of_face=(np.zeros(12, dtype=np.int64),)
    )
    assert (
        build_physics(solidify([mesh])[0], [], work_dir=tmp_path, mass_inputs=mass_inputs).section.material.value
        == "wood"
    )


def _both(one: Mesh, other: Mesh) -> np.ndarray:
    return np.concatenate([one.triangles, other.triangles + len(one.points)])
