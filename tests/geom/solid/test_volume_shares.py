"""How a solid divides among its materials: closed forms, overlaps counted once, paint on one skin."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from geom.mass.inertia import combine, combine_volumes, moved, of_box
from geom.pose import pose
from geom.solid.solidify import solidify
from geom.solid.volume_shares import divide_volume
from schemas.model import Mesh
from schemas.physics import MassProperties
from tests.support.package_samples import mesh_from

LONG, SHORT = ((0.3, 0.1, 0.1), (0.05, 0.0, 0.0)), ((0.1, 0.1, 0.1), (-0.15, 0.0, 0.0))


def box(size, at=(0.0, 0.0, 0.0), name="box") -> Mesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(at)
    return mesh_from(mesh, name)


def cut(mesh: Mesh, first: np.ndarray) -> tuple[Mesh, Mesh]:
    """The faces where `first` is True, and the others: one skin, two paints."""
    return (
        Mesh("first", mesh.points, mesh.triangles[first]),
        Mesh("second", mesh.points, mesh.triangles[~first]),
    )


def without_face(mesh: Mesh, x_m: float) -> Mesh:
    """`mesh` without the faces in the plane x = `x_m`."""
    remaining = np.abs(mesh.points[mesh.triangles][..., 0] - x_m).max(axis=1) > 1e-9
    return Mesh(mesh.name, mesh.points, mesh.triangles[remaining])


def weighed(groups, densities) -> tuple[list[MassProperties], MassProperties, bool]:
    solid, _ = solidify([mesh for group in groups for mesh in group])
    evidence = divide_volume(solid, groups, densities)
    bodies = [share.filled(density) for share, density in zip(evidence.shares, densities, strict=True)]
    return bodies, combine([b for b in bodies if b.mass_kg > 0]), evidence.exact


def at(size, density, centre) -> MassProperties:
    return moved(of_box(size, density), pose(None, centre))


def assert_same(a: MassProperties, b: MassProperties, rtol=1e-6) -> None:
    assert_allclose(a.mass_kg, b.mass_kg, rtol=rtol)
    assert_allclose(a.centre_of_mass_m, b.centre_of_mass_m, atol=rtol)
    assert_allclose(a.inertia_kgm2, b.inertia_kgm2, atol=rtol * np.abs(b.inertia_kgm2).max())


def test_a_wooden_handle_and_a_steel_head_side_by_side():
    groups = [[box((0.3, 0.03, 0.03))], [box((0.03, 0.1, 0.04), (0.165, 0, 0))]]
    bodies, total, exact = weighed(groups, [650.0, 7850.0])
    assert exact
    handle, head = at((0.3, 0.03, 0.03), 650, (0, 0, 0)), at((0.03, 0.1, 0.04), 7850, (0.165, 0, 0))
    assert_same(bodies[0], handle)
    assert_same(bodies[1], head)
    assert_same(total, combine([handle, head]))


def test_a_million_metres_away_the_division_is_the_same():
    away = np.array([1e6, -5e5, 2e5])
    near = [box(*LONG), box(SHORT[0], (-0.12, 0, 0))]
    far = [Mesh(m.name, m.points + away, m.triangles) for m in near]
    _, here, _ = weighed([[m] for m in near], [650.0, 7850.0])
    _, there, exact = weighed([[m] for m in far], [650.0, 7850.0])
    assert exact
    assert_same(there, moved(here, pose(None, away)), rtol=1e-6)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_denser_body_keeps_the_shared_volume(order):
    """A block of 0.2 x 0.1 x 0.1 and one half as long that reaches into it by a quarter of its length."""
    groups = [[box((0.2, 0.1, 0.1))], [box((0.1, 0.1, 0.1), (0.1, 0, 0))]]
    densities = [650.0, 7850.0]
    bodies, total, exact = weighed([groups[i] for i in order], [densities[i] for i in order])
    assert exact
    wood, steel = at((0.15, 0.1, 0.1), 650, (-0.025, 0, 0)), at((0.1, 0.1, 0.1), 7850, (0.1, 0, 0))
    assert_same(bodies[order.index(0)], wood)
    assert_same(bodies[order.index(1)], steel)
    assert_same(total, combine([wood, steel]))


def test_a_bolt_buried_in_wood_displaces_it():
    groups = [[box((0.2, 0.2, 0.2))], [box((0.1, 0.02, 0.02))]]
    bodies, _, exact = weighed(groups, [650.0, 7850.0])
    assert exact
    assert bodies[0].mass_kg == pytest.approx(650.0 * (0.2**3 - 0.1 * 0.02**2))
    assert bodies[1].mass_kg == pytest.approx(7850.0 * 0.1 * 0.02**2)


def test_a_foam_core_stays_in_its_steel_case():
    """The denser body would leave nothing of it."""
    bodies, _, exact = weighed([[box((0.1, 0.1, 0.1))], [box((0.08, 0.08, 0.08))]], [7850.0, 50.0])
    assert exact
    assert bodies[0].mass_kg == pytest.approx(7850.0 * (0.1**3 - 0.08**3))
    assert bodies[1].mass_kg == pytest.approx(50.0 * 0.08**3)


def test_the_other_reading_gives_the_shared_volume_to_the_lighter():
    """Two cubes, half in each other; a third far away shares nothing, a bolt wholly inside has no other reading."""
    cubes = [[box((0.1, 0.1, 0.1))], [box((0.1, 0.1, 0.1), (0.05, 0, 0))], [box((0.1, 0.1, 0.1), (1.0, 0, 0))]]
    solid, _ = solidify([mesh for group in cubes for mesh in group])
    made = divide_volume(solid, cubes, [650.0, 7850.0, 2700.0])
    assert made.alternative is not None
    assert [s.volume_m3 for s in made.shares] == pytest.approx([5e-4, 1e-3, 1e-3])
    assert [s.volume_m3 for s in made.alternative] == pytest.approx([1e-3, 5e-4, 1e-3])
    assert "denser" in made.reason
    bolt = [[box((0.2, 0.2, 0.2))], [box((0.1, 0.02, 0.02))]]
    assert divide_volume(solidify([m for g in bolt for m in g])[0], bolt, [650.0, 7850.0]).alternative is None
    apart = [cubes[0], cubes[2]]
    assert divide_volume(solidify([m for g in apart for m in g])[0], apart, [650.0, 7850.0]).reason == ""


def test_mass_bounds_hold_whichever_material_keeps_what_two_share():
    meshes = [box((0.1, 0.1, 0.1), name="steel"), box((0.1, 0.1, 0.1), (0.05, 0, 0), name="wood")]
    masses = mass_evidence(solidify(meshes)[0], [], MassEvidenceInputs(meshes=tuple(meshes)))
    low, high = np.array(masses.mass_kg.bounds)
    lighter = 7850.0 * 5e-4 + 650.0 * 1e-3
    assert low <= lighter <= masses.mass_kg.value <= high
    assert "denser" in masses.mass_kg.method
    (note,) = masses.diagnostics
    assert (note.code, note.bound) == ("asset/overlapping-bodies", pytest.approx(lighter))
    assert "steel keeps" in note.headline
    centre = combine([at((0.1,) * 3, 650, (0.05, 0, 0)), at((0.05, 0.1, 0.1), 7850, (-0.025, 0, 0))])
    near, far = np.array(masses.centre_of_mass_m.bounds)
    assert (near <= centre.centre_of_mass_m).all()
    assert (centre.centre_of_mass_m <= far).all()


def test_among_equals_the_group_listed_first_keeps_it():
    groups = [[box((0.2, 0.1, 0.1))], [box((0.1, 0.1, 0.1), (0.1, 0, 0))]]
    bodies, total, _ = weighed(groups, [500.0, 500.0])
    assert bodies[0].mass_kg == pytest.approx(1.0)
    assert bodies[1].mass_kg == pytest.approx(0.25)
    assert total.mass_kg == pytest.approx(500.0 * 0.25 * 0.01)


def test_one_skin_in_two_paints_is_cut_along_the_paint():
    parts = [without_face(box(size, centre), x_m=-0.1) for size, centre in (LONG, SHORT)]
    bodies, total, exact = weighed([[parts[0]], [parts[1]]], [650.0, 7850.0])
    assert exact
    wood, steel = at(LONG[0], 650, LONG[1]), at(SHORT[0], 7850, SHORT[1])
    assert_same(bodies[0], wood)
    assert_same(bodies[1], steel)
    assert_same(total, combine([wood, steel]))


def test_a_paint_of_several_open_skins_caps_each_of_them():
    """A bar with both ends in steel. Each end has one mouth, whose faces are numbered over both ends."""
    steel = [without_face(box((0.1, 0.1, 0.1), (x, 0, 0)), -0.1 if x < 0 else 0.1) for x in (-0.15, 0.15)]
    wood = without_face(without_face(box((0.2, 0.1, 0.1)), -0.1), 0.1)
    bodies, total, exact = weighed([steel, [wood]], [7850.0, 650.0])
    assert exact
    ends = combine([at((0.1, 0.1, 0.1), 7850, (x, 0, 0)) for x in (-0.15, 0.15)])
    assert_same(bodies[0], ends)
    assert_same(bodies[1], of_box((0.2, 0.1, 0.1), 650.0))
    assert_same(total, combine([ends, of_box((0.2, 0.1, 0.1), 650.0)]))


def test_the_glaze_inside_a_cup_has_no_volume_of_its_own():
    """The inner skin, capped, would be the drink: shares by visible area instead, spread evenly."""
    cup = trimesh.creation.revolve([[0, 0], [0.04, 0], [0.04, 0.1], [0.036, 0.1], [0.036, 0.004], [0, 0.004]])
    inner = (np.hypot(*cup.triangles_center[:, :2].T) < 0.0365) & (cup.triangles_center[:, 2] > 0.003)
    parts = cut(mesh_from(cup), inner)
    bodies, total, exact = weighed([[parts[0]], [parts[1]]], [2300.0, 2300.0])
    assert not exact
    share = cup.area_faces[inner].sum() / cup.area
    assert bodies[0].mass_kg / total.mass_kg == pytest.approx(share, rel=1e-6)
    assert total.mass_kg == pytest.approx(2300 * cup.volume, rel=1e-6)
    assert_allclose(total.centre_of_mass_m, cup.center_mass, atol=1e-9)


def test_a_sticker_weighs_nothing():
    sticker = Mesh(
        "label", np.array([[0.05, -0.02, -0.02], [0.05, 0.02, -0.02], [0.05, 0.0, 0.02]]), np.array([[0, 1, 2]])
    )
    bodies, total, exact = weighed([[box((0.1, 0.1, 0.1))], [sticker]], [650.0, 700.0])
    assert exact
    assert bodies[1].mass_kg == 0.0
    assert_same(total, of_box((0.1, 0.1, 0.1), 650.0))


def test_sheets_divide_by_their_area():
    """An open tray: floor of one material, rim of another, both as thick as the assumed wall."""
    tray = trimesh.creation.box((0.3, 0.2, 0.1))
    open_faces = tray.triangles_center[:, 2] < 0.049
    tray.update_faces(open_faces)
    floor = tray.triangles_center[:, 2] < -0.049
    parts = cut(mesh_from(tray), floor)
    solid, _ = solidify(parts)
    assert solid.wall_thickness_m is not None
    made = divide_volume(solid, [[parts[0]], [parts[1]]], [1.0, 2.0])
    assert made.exact
    assert made.shares[0].volume_m3 == pytest.approx(0.06 * solid.wall_thickness_m)
    assert made.shares[1].volume_m3 == pytest.approx(0.1 * solid.wall_thickness_m)
    assert_allclose(made.shares[0].centre_m, [0, 0, -0.05], atol=1e-9)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_equal_densities_give_back_the_whole(seed):
    rng = np.random.default_rng(seed)
    groups = [[box(rng.uniform(0.05, 0.2, 3), rng.uniform(-0.1, 0.1, 3))] for _ in range(3)]
    solid, figures = solidify([mesh for group in groups for mesh in group])
    made = divide_volume(solid, groups, [1.0, 1.0, 1.0])
    total = combine_volumes([share for share in made.shares if share.volume_m3 > 0])
    whole = trimesh.Trimesh(solid.points, solid.triangles, process=False)
    assert made.exact
    assert total.volume_m3 == pytest.approx(figures["volume_m3"], rel=1e-9)
    assert_allclose(total.centre_m, whole.center_mass, atol=1e-7)
    assert_allclose(total.second_moment_m5, whole.moment_inertia, atol=1e-6 * np.abs(whole.moment_inertia).max())
