"""The physics stage: the simplest shape that fits, openings kept, mass with honest bounds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

from assetkit.colliders.choose import choose_colliders
from assetkit.mass.bounds import MAX_SPAN
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.physics.build import build_physics, inertia_beyond
from assetkit.taxonomy.material_classes import UNKNOWN_FULL, materials
from geom.convex.support_function import surface
from geom.features.cavities import find_cavities, keeps_cavity
from geom.mass.inertia import is_physical, of_box
from geom.pose import apply, pose
from schemas.diagnostics import Location
from schemas.physics import CollisionShape, Solid
from schemas.stated_physics import StatedMass
from tests.support.package_samples import box_mesh, hull_shape
from tests.support.present import present


def solid_of(body: Manifold) -> Solid:
    mesh = body.to_mesh64()
    return Solid(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32), "closed")


def solid_from(shape: CollisionShape) -> Solid:
    points, triangles = surface(shape)
    return Solid(points, triangles.astype(np.int32), "closed")


def lidless_box(wall=0.003) -> Solid:
    box = trimesh.creation.box((0.3, 0.2, 0.15))
    faces = np.array(box.faces)[np.abs(box.triangles_center[:, 2] - 0.075) > 1e-6]
    return Solid(np.array(box.vertices), faces.astype(np.int32), "shell", wall)


@pytest.mark.parametrize(
    ("kind", "size"),
    [("box", (0.3, 0.2, 0.1)), ("sphere", (0.1,)), ("capsule", (0.05, 0.2)), ("cylinder", (0.05, 0.2))],
)
def test_a_simple_shape_is_recognised(kind, size, tmp_path):
    shape = CollisionShape(kind, size, pose(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3], (1, 2, 3)))
    built = build_physics(solid_from(shape), [], work_dir=tmp_path)
    assert built.section.collision_method == kind
    assert built.diagnostics == ()
    np.testing.assert_allclose(sorted(built.shapes[0].size_m), sorted(size), rtol=0.01)
    assert built.section.candidates[-1].accepted
    assert [c.accepted for c in built.section.candidates[:-1]] == [False] * (len(built.section.candidates) - 1)


def test_a_wedge_is_a_hull(tmp_path):
    wedge = Manifold.hull_points(
        np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0.2, 0.1, 0], [0, 0, 0.1], [0, 0.1, 0.1]])
    )
    built = build_physics(solid_of(wedge), ["oak_wedge"], work_dir=tmp_path)
    assert built.section.collision_method == "hull"
    assert present(built.shapes[0].points).shape == (6, 3)
    assert built.mass.mass_kg == pytest.approx(0.001 * 650.0)
    assert built.section.material.value == "wood"


def test_a_cup_is_decomposed_and_stays_open(tmp_path):
    cup = Manifold.cylinder(0.1, 0.04, 0.04, 24) - Manifold.cylinder(0.1, 0.036, 0.036, 24).translate((0, 0, 0.005))
    solid = solid_of(cup)
    built = build_physics(solid, ["mug"], work_dir=tmp_path)
    assert built.section.collision_method == "cuts"
    assert all(keeps_cavity(built.shapes, cavity) for cavity in find_cavities(solid))
    filled = {c.method: c.cavity_kept for c in built.section.candidates}
    assert filled == {"box": False, "sphere": False, "capsule": False, "cylinder": False, "hull": False, "cuts": True}
    assert build_physics(solid, ["mug"], work_dir=tmp_path).section == built.section


def test_a_sheet_container_stays_open_and_has_no_volume_ratio(tmp_path):
    solid = lidless_box()
    built = build_physics(solid, ["box"], work_dir=tmp_path)
    assert all(keeps_cavity(built.shapes, cavity) for cavity in find_cavities(solid))
    assert {c.volume_ratio for c in built.section.candidates} == {None}
    assert built.mass.mass_kg == pytest.approx(materials()[UNKNOWN_FULL].density_kgm3 * 0.003 * 0.21)
    assert built.section.mass_kg.source == "default"


def test_a_card_is_a_thin_box_of_the_assumed_wall(tmp_path):
    card = np.array([[0, 0, 0], [0.09, 0, 0], [0.09, 0.06, 0], [0, 0.06, 0]], dtype=float)
    built = build_physics(
        Solid(card, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), "shell", 0.001), [], work_dir=tmp_path
    )
    assert built.section.collision_method == "box"
    np.testing.assert_allclose(sorted(built.shapes[0].size_m), [0.001, 0.06, 0.09])
    assert is_physical(built.mass.inertia_kgm2)


def test_a_flat_hull_still_gets_a_body_and_a_warning(tmp_path):
    card = np.array([[0, 0, 0], [0.09, 0, 0], [0.09, 0.06, 0], [0, 0.06, 0]], dtype=float)
    built = build_physics(Solid(card, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), "hull"), [], work_dir=tmp_path)
    assert [d.code for d in built.diagnostics] == ["asset/collision-fallback"]
    assert built.shapes[0].kind == "box"
    assert built.mass.mass_kg > 0
    assert is_physical(built.mass.inertia_kgm2)


def test_an_excluded_method_is_not_chosen_again(tmp_path):
    solid = solid_from(CollisionShape("box", (0.3, 0.2, 0.1), np.eye(4)))
    built = build_physics(solid, [], work_dir=tmp_path, exclude=frozenset({"box"}))
    assert built.section.collision_method == "hull"


def test_a_comb_too_fine_for_its_budget_falls_back_with_evidence(tmp_path):
    comb = Manifold.cube((1.0, 0.1, 0.05))
    for k in range(34):
        comb += Manifold.cube((0.008, 0.1, 0.3)).translate((k / 34, 0, 0.05))
    built = build_physics(solid_of(comb), [], work_dir=tmp_path)
    assert 0 < len(built.shapes) <= 32
    rejected = [c for c in built.section.candidates if not c.accepted]
    assert all(c.reason for c in rejected)
    if not any(c.accepted for c in built.section.candidates):
        assert built.diagnostics[0].code == "asset/collision-fallback"
        assert len(built.diagnostics[0].because) == len(built.section.candidates) - 1


@pytest.mark.parametrize("name", sorted(materials()))
@pytest.mark.parametrize("kind", ["closed", "shell", "hull"])
def test_mass_bounds_hold_the_value_and_never_span_more_than_thirty(name, kind):
    box = trimesh.creation.box((0.1, 0.1, 0.2))
    wall = 0.002 if kind == "shell" else None
    solid = Solid(np.array(box.vertices), np.array(box.faces, dtype=np.int32), kind, wall)
    word = next(iter(sorted(materials()[name].words)), "thing")
    mass = mass_evidence(solid, [word], MassEvidenceInputs()).mass_kg
    assert mass.bounds is not None
    low, high = mass.bounds
    assert 0 < low <= mass.value <= high <= MAX_SPAN * low * (1 + 1e-9)


def test_a_solid_can_may_be_hollow_and_a_solid_stone_is_not(tmp_path):
    solid = solid_from(CollisionShape("cylinder", (0.05, 0.14), np.eye(4)))
    can = build_physics(solid, ["plastic_can"], work_dir=tmp_path).section.mass_kg
    stone = build_physics(solid, ["stone"], work_dir=tmp_path).section.mass_kg
    assert can.bounds is not None
    assert stone.bounds is not None
    assert can.bounds[0] < 0.2 * can.value
    assert stone.bounds[0] > 0.6 * stone.value
    assert can.confidence < 0.5


def test_inertia_and_mass_centre_follow_the_body(tmp_path):
    X = pose(None, (3.0, -2.0, 1.0))
    solid = solid_from(CollisionShape("cylinder", (0.05, 0.2), np.eye(4)))
    here = build_physics(solid, [], work_dir=tmp_path)
    there = build_physics(Solid(apply(X, solid.points), solid.triangles, "closed"), [], work_dir=tmp_path)
    np.testing.assert_allclose(there.mass.centre_of_mass_m, here.mass.centre_of_mass_m + X[:3, 3], atol=1e-9)
    np.testing.assert_allclose(there.mass.inertia_kgm2, here.mass.inertia_kgm2, rtol=1e-6, atol=1e-12)
    evidence = here.section.centre_of_mass_m
    assert evidence.source == "measured"
    assert evidence.bounds is not None
    assert np.less_equal(evidence.bounds[0], evidence.value).all()
    assert np.less_equal(evidence.value, evidence.bounds[1]).all()


def test_a_feather_is_not_clamped(tmp_path):
    tiny = solid_from(CollisionShape("box", (1e-4, 1e-4, 1e-4), np.eye(4)))
    built = build_physics(tiny, ["foam"], work_dir=tmp_path)
    assert built.mass.mass_kg == pytest.approx(60e-12)
    assert is_physical(built.mass.inertia_kgm2)


@pytest.mark.shared
def test_a_scanned_pan_keeps_its_inside(shared_assets: Path, tmp_path: Path) -> None:
    mesh = trimesh.load_mesh(next((shared_assets / "obj" / "gso_frypan_obj").rglob("*.obj")), process=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    solid = Solid(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int32), "closed")
    cavities = find_cavities(solid)
    built = build_physics(solid, ["frypan"], work_dir=tmp_path)
    assert len(cavities) == 1
    assert built.diagnostics == ()
    assert all(keeps_cavity(built.shapes, cavity) for cavity in cavities)


def test_a_stated_inertia_that_reaches_beyond_the_colliders_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Colliders that leave out both ends of a bar: its true tensor would be refused by the gate."""
    bar = box_mesh((1.0, 0.1, 0.1), source_path="/bar")
    solid = Solid(bar.points, bar.triangles, "closed")
    exact = of_box((1.0, 0.1, 0.1), 500.0)
    spread = exact.inertia_kgm2 * np.diag([1.0, 2.0, 2.0])  # much of the mass at the ends
    where = Location(file="test")
    stated = StatedMass(
        ("/bar",), 12, "test", where, mass_kg=exact.mass_kg, centre=np.array([0.0, 0.0, 0.05]), inertia=spread
    )
    inputs = MassEvidenceInputs(meshes=(bar,), as_read=(bar,), masses=(stated,))
    whole = build_physics(solid, [], work_dir=tmp_path, mass_inputs=inputs)
    assert whole.mass.inertia_kgm2 == pytest.approx(spread)
    assert whole.repairs == ()

    def short(*arguments: object) -> object:
        chosen = choose_colliders(*arguments)  # pyright: ignore[reportArgumentType]
        middle = box_mesh((0.7, 0.1, 0.1))
        return replace(chosen, shapes=(hull_shape(middle),))

    monkeypatch.setattr("assetkit.physics.build.choose_colliders", short)
    cut = build_physics(solid, [], work_dir=tmp_path, mass_inputs=inputs)
    assert cut.mass.mass_kg == pytest.approx(exact.mass_kg)
    assert cut.mass.inertia_kgm2 == pytest.approx(exact.inertia_kgm2, rel=1e-6)
    assert [r.name for r in cut.repairs] == ["implausible_inertia"]
    (note,) = [d for d in cut.diagnostics if d.code == "asset/source-inertia-implausible"]
    assert isinstance(note.value, float)
    assert isinstance(note.bound, float)
    assert note.value > note.bound > 0.0
    assert inertia_beyond(cut.mass, cut.shapes) is None
