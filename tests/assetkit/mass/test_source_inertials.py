"""Stated masses, mass centres and tensors: believed when possible, dropped with value and bound when not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.mass.source_inertials import applicable_statements, check_statement, in_asset_frame
from assetkit.pose.up_axis import TO_Z_UP
from geom.mass.inertia import box_volume, enclosed_volume, inertia_about, moved, of_box, sheet_volume
from geom.mass.inertia_bounds import rms_distance_and_bound
from geom.pose import pose
from schemas.diagnostics import Location, Severity
from schemas.model import Mesh
from schemas.physics import MassProperties, Solid
from schemas.stated_physics import StatedMass
from tests.support.package_samples import box_mesh
from tests.support.present import present

SIZE = (0.2, 0.1, 0.06)
EVEN = box_volume(SIZE, pose(None, (0.0, 0.0, 0.03)))
MESH = box_mesh(SIZE)
SOLID = Solid(MESH.points, MESH.triangles, "closed")
SHAPES = (
    trimesh.creation.box((0.2, 0.1, 0.05)),
    trimesh.creation.icosphere(subdivisions=2, radius=0.1),
    trimesh.creation.cylinder(0.01, 0.5),
    trimesh.creation.annulus(0.05, 0.1, 0.02),
)


def stated(mass_kg: float | None = 0.9, **changes) -> StatedMass:
    return StatedMass(("/part",), 12, "test", Location(prim="/part"), mass_kg=mass_kg, **changes)


def of(body: MassProperties) -> StatedMass:
    return stated(body.mass_kg, centre=body.centre_of_mass_m, inertia=body.inertia_kgm2)


def outcome_of(statement: StatedMass, exact: bool = True) -> tuple[StatedMass | None, list[str], list[str]]:
    checked = check_statement(statement, MESH.points, EVEN, exact=exact)
    return checked.stated, [d.headline for d in checked.diagnostics], [r.name for r in checked.repairs]


def test_the_truth_is_believed_as_it_is():
    truth = of(EVEN.filled(700.0))
    assert outcome_of(truth) == (truth, [], [])


@pytest.mark.parametrize("mass_kg", [-1.0, np.nan, np.inf, 1e-5, 40.0])
def test_an_impossible_mass_drops_everything(mass_kg):
    kept, headlines, repairs = outcome_of(replace(of(EVEN.filled(700.0)), mass_kg=mass_kg))
    assert kept is None
    assert "mass" in headlines[0]
    assert repairs == ["implausible_inertia"]


def test_the_finding_names_value_bound_and_place():
    (found,) = check_statement(stated(60.0), MESH.points, EVEN, exact=True).diagnostics
    assert found.code == "asset/source-inertia-implausible"
    assert (found.value, found.bound, found.unit) == (pytest.approx(50_000), 25_000, "kg/m3")
    assert found.where.prim == "/part"


def test_a_low_centre_without_a_tensor_is_kept_and_the_filling_squeezed_about_it():
    """4 % of the height: a weighted base. The even filling about it would need mass below the floor."""
    found = check_statement(stated(centre=np.array([0.0, 0.0, 0.0024])), MESH.points, EVEN, exact=True)
    assert found.stated is not None
    assert found.stated.centre is not None
    assert [d.severity for d in found.diagnostics] == [Severity.INFO]
    assert [r.name for r in found.repairs] == ["squeezed_inertia"]
    evidence = mass_evidence(SOLID, ["part"], mass_inputs(stated(centre=np.array([0.0, 0.0, 0.0024]))))
    reach, most = rms_distance_and_bound(
        evidence.properties.inertia_kgm2 / 0.9, MESH.points - evidence.properties.centre_of_mass_m
    )
    assert reach <= 0.9 * most
    assert evidence.inertia_kgm2.source == "inferred"
    assert "squeezed" in evidence.inertia_kgm2.method
    low, high = (np.array(b) for b in evidence.inertia_kgm2.bounds or ())
    assert (low <= evidence.properties.inertia_kgm2 + 1e-15).all()
    assert (evidence.properties.inertia_kgm2 <= high + 1e-15).all()
    weighted = box_volume((0.2, 0.1, 0.0048), pose(None, (0.0, 0.0, 0.0024)))  # All in a base plate.
    truth = weighted.filled(0.9 / weighted.volume_m3).inertia_kgm2
    assert (np.diag(low) <= np.diag(truth)).all()
    assert (np.diag(truth) <= np.diag(high)).all()


@pytest.mark.parametrize("depth_m", [0.0, 1.5e-5])
def test_a_centre_on_the_skin_is_dropped_where_no_tensor_comes_with_it(depth_m: float):
    """15 mm written as 15 micrometres: on the skin no body but a film has its mass."""
    kept, headlines, repairs = outcome_of(stated(centre=np.array([0.0, 0.0, depth_m])))
    assert kept is not None
    assert kept.centre is None
    assert headlines == ["the stated mass centre lies on the skin of the object"]
    assert repairs == ["implausible_inertia"]


def test_a_centre_that_is_little_aside_leaves_the_even_filling_alone():
    found = check_statement(stated(centre=np.array([0.01, 0.0, 0.025])), MESH.points, EVEN, exact=True)
    assert (found.diagnostics, found.repairs, found.squeeze) == ((), (), None)


def test_a_guessed_volume_is_no_strong_witness():
    assert outcome_of(stated(60.0), exact=False)[0] is not None


@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.5), (np.nan, 0.0, 0.0), (0.15, 0.0, 0.03)])
def test_a_centre_outside_is_dropped_with_the_tensor_about_it(centre):
    kept, headlines, _ = outcome_of(replace(of(EVEN.filled(700.0)), centre=np.array(centre)))
    assert kept is not None
    assert (kept.mass_kg, kept.centre, kept.inertia) == (pytest.approx(0.84), None, None)
    assert "centre" in headlines[0]


def test_a_centre_on_the_skin_is_kept_with_its_tensor():
    """The visible mesh may be tighter than the thing."""
    plate = box_volume((0.2, 0.1, 0.004), pose(None, (0.0, 0.0, -0.001)))
    kept, headlines, _ = outcome_of(of(plate.filled(0.9 / plate.volume_m3)))
    assert headlines == []
    assert kept is not None
    assert kept.centre is not None


@pytest.mark.parametrize(
    ("inertia", "word"),
    [
        (np.diag([1e-3, 1e-3, -1e-3]), "positive"),
        (np.diag([np.nan, 1e-3, 1e-3]), "positive"),
        (np.diag([1e-3, 1e-3, 2.1e-3]), "sum"),
        (np.eye(3), "too large"),  # The placeholder of many files.
        (1e-7 * np.eye(3), "too small"),
    ],
)
def test_an_impossible_tensor_is_dropped_and_the_rest_kept(inertia, word):
    centre = np.array([0.0, 0.0, 0.03])
    found = check_statement(stated(centre=centre, inertia=inertia), MESH.points, EVEN, exact=True)
    assert found.stated is not None
    assert_allclose(present(found.stated.centre), centre)
    assert found.stated.inertia is None
    assert word in found.diagnostics[0].headline


def test_a_tensor_that_needs_mass_outside_is_dropped():
    """Three times the even body: its trace may be that of a frame of edges, but not of this size."""
    truth = of(EVEN.filled(700.0))
    kept, headlines, _ = outcome_of(replace(truth, inertia=3.2 * present(truth.inertia)))
    assert kept is not None
    assert kept.inertia is None
    assert headlines == ["the stated inertia needs mass outside the object"]


def test_a_rod_whose_long_axis_is_another_is_noticed():
    rod = box_volume((0.01, 0.01, 0.4), pose(None, (0.0, 0.0, 0.2)))
    truth = of(rod.filled(1000.0))
    points = box_mesh((0.01, 0.01, 0.4)).points
    assert check_statement(truth, points, rod, exact=True).diagnostics == ()
    along_x = replace(truth, inertia=np.roll(present(truth.inertia), 1, axis=(0, 1)))
    assert "other axes" in check_statement(along_x, points, rod, exact=True).diagnostics[0].headline


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(SHAPES), st.floats(20.0, 20_000.0), st.integers(0, 2**32 - 1))
def test_no_true_body_is_ever_doubted(shape, density, seed):
    """Any shape, any pose, solid or a thin skin of it."""
    X = pose(
        Rotation.random(rng=np.random.default_rng(seed)).as_matrix(), np.random.default_rng(seed).uniform(-1, 1, 3)
    )
    body = shape.copy()
    body.apply_transform(X)
    points, triangles = np.array(body.vertices), np.array(body.faces)
    even = enclosed_volume(points, triangles)
    skin = sheet_volume(points, triangles, 0.001).filled(max(density, 400.0))
    for truth in (even.filled(density), skin):
        assert check_statement(of(truth), points, even, exact=True).diagnostics == ()


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_frames_and_units(axis):
    """A body stated in centimetres about another origin and axis is the same body in metres."""
    R_AM, origin = TO_Z_UP[axis], np.array([0.3, -0.2, 0.05])
    truth = moved(of_box(SIZE, 700.0), pose(Rotation.from_rotvec([0.3, 0.1, 0.2]).as_matrix(), (0.01, 0.02, 0.03)))
    in_metres = MassProperties(
        truth.mass_kg, R_AM.T @ (truth.centre_of_mass_m - origin), R_AM.T @ truth.inertia_kgm2 @ R_AM
    )
    in_cm = replace(of(in_metres), centre=in_metres.centre_of_mass_m * 100, inertia=in_metres.inertia_kgm2 * 1e4)
    back = in_asset_frame(replace(in_cm, density=7e-4), R_AM, 0.01, origin)
    assert_allclose(present(back.centre), truth.centre_of_mass_m, atol=1e-12)
    assert_allclose(present(back.inertia), truth.inertia_kgm2, atol=1e-15)
    assert back.density == pytest.approx(700.0)


def part(path: str, triangles: int) -> Mesh:
    return Mesh("part", MESH.points, MESH.triangles[:triangles], source_path=path)


def test_a_mass_of_several_objects_is_nobodys():
    both = replace(stated(2.0), covers=("/a", "/b"), triangles=24)
    kept, notes = applicable_statements([both], [part("/a", 12)])
    assert kept == []
    assert notes[0].severity is Severity.INFO
    assert applicable_statements([both], [part("/a", 12), part("/b", 12)]) == ([both], [])
    assert applicable_statements([both], [part("/elsewhere", 12)]) == ([], [])
    density = replace(both, mass_kg=None, density=500.0)
    assert applicable_statements([density], [part("/a", 12)]) == ([density], [])


def mass_inputs(*masses: StatedMass, meshes: tuple[Mesh, ...] = ()) -> MassEvidenceInputs:
    seen = meshes or (replace(MESH, source_path="/part"),)
    return MassEvidenceInputs(meshes=seen, as_read=seen, masses=masses)


def test_a_mass_alone_scales_the_computed_tensor():
    found = mass_evidence(SOLID, ["wood"], mass_inputs(stated(2.0)))
    even = EVEN.filled(2.0 / EVEN.volume_m3)
    assert (found.mass_kg.value, found.mass_kg.source, found.mass_kg.bounds) == (2.0, "declared", (1.8, 2.2))
    assert_allclose(found.properties.inertia_kgm2, even.inertia_kgm2, atol=1e-12)
    assert_allclose(found.properties.centre_of_mass_m, [0, 0, 0.03], atol=1e-12)
    assert (found.inertia_kgm2.source, found.centre_of_mass_m.source) == ("inferred", "inferred")
    assert found.density_kgm3.value == pytest.approx(2.0 / np.prod(SIZE))
    assert found.mass_kg.confidence > 0.9 > found.inertia_kgm2.confidence


def test_mass_and_centre_without_tensor_keep_the_centre():
    centre = np.array([0.02, 0.0, 0.02])
    found = mass_evidence(SOLID, [], mass_inputs(stated(2.0, centre=centre)))
    assert_allclose(found.properties.centre_of_mass_m, centre)
    assert found.centre_of_mass_m.source == "declared"
    assert_allclose(found.properties.inertia_kgm2, EVEN.filled(2.0 / EVEN.volume_m3).inertia_kgm2, atol=1e-12)


def test_a_stated_density_weighs_the_solid():
    found = mass_evidence(SOLID, [], mass_inputs(stated(None, density=1234.0)))
    assert found.mass_kg.value == pytest.approx(1234.0 * np.prod(SIZE))
    assert found.density_kgm3.source == "declared"
    assert found.density_kgm3.bounds == pytest.approx((0.9 * 1234.0, 1.1 * 1234.0))
    low, high = found.mass_kg.bounds or (0.0, 0.0)
    assert (low, high) == pytest.approx((0.9 * 0.95 * found.mass_kg.value, 1.1 * 1.05 * found.mass_kg.value))
    assert "stated density, 10 % either way" in found.mass_kg.method
    absurd = mass_evidence(SOLID, ["wood"], mass_inputs(stated(None, density=1e6)))
    assert absurd.density_kgm3.method == "material class wood"
    assert [d.code for d in absurd.diagnostics] == ["asset/source-inertia-implausible"]


def test_two_stated_parts_are_composed_about_their_common_centre():
    left, right = box_mesh((0.1, 0.1, 0.1), "left"), box_mesh((0.1, 0.1, 0.1), "right", (0.1, 0.0, 0.0))
    meshes = (replace(left, source_path="/left"), replace(right, source_path="/right"))
    solid = Solid(box_mesh((0.2, 0.1, 0.1), shift=(0.05, 0, 0)).points, MESH.triangles, "closed")
    masses = [replace(stated(m), covers=(p,)) for m, p in ((1.0, "/left"), (3.0, "/right"))]
    found = mass_evidence(solid, [], mass_inputs(*masses, meshes=meshes))
    assert found.mass_kg.value == pytest.approx(4.0)
    assert_allclose(found.properties.centre_of_mass_m, [0.075, 0, 0.05], atol=1e-9)
    halves = [moved(of_box((0.1,) * 3, m / 1e-3), pose(None, (x, 0, 0.05))) for m, x in ((1.0, 0.0), (3.0, 0.1))]
    about = sum(inertia_about(h, found.properties.centre_of_mass_m) for h in halves)
    assert_allclose(found.properties.inertia_kgm2, about, atol=1e-9)
    assert found.mass_kg.source == "declared"


def test_one_stated_part_leaves_the_other_to_its_material():
    left, right = box_mesh((0.1, 0.1, 0.1), "left"), box_mesh((0.1, 0.1, 0.1), "oak", (0.1, 0.0, 0.0))
    meshes = (replace(left, source_path="/left"), replace(right, source_path="/right"))
    solid = Solid(box_mesh((0.2, 0.1, 0.1), shift=(0.05, 0, 0)).points, MESH.triangles, "closed")
    found = mass_evidence(solid, [], mass_inputs(replace(stated(5.0), covers=("/left",)), meshes=meshes))
    assert found.mass_kg.value == pytest.approx(5.65)
    assert found.mass_kg.source == "inferred"
    assert found.mass_kg.bounds == pytest.approx((4.5 + 0.35, 5.5 + 0.95))
    assert [p.meshes for p in found.parts] == [("left",), ("oak",)]
    assert [p.mass_share for p in found.parts] == pytest.approx([5 / 5.65, 0.65 / 5.65])
    assert found.parts[0].density_kgm3.value == pytest.approx(5000.0)
