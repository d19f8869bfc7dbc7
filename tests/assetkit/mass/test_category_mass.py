"""Mass of objects by category and size: laws of the mixture, names that identify the kind, a table of objects."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
import trimesh
from scipy.stats import norm

from assetkit.mass.bounds import bounds_around
from assetkit.mass.category_mass import MAX_CATEGORY_SPAN, CategoryMassEstimate, category_mass, reference_size
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.normal_mixture import NormalMixture
from assetkit.mass.parts import METRES, MassEvidenceInputs
from assetkit.taxonomy.category_masses import category_masses, masses_of_kind
from assetkit.taxonomy.tables import categories
from benchmarks.assets.masses.named_masses import things, weighed
from schemas.physics import Solid
from tests.support.present import present

CUP = [(0, 0), (0.04, 0), (0.04, 0.1), (0.037, 0.1), (0.037, 0.003), (0, 0.003)]


def solid(mesh: trimesh.Trimesh, kind: Literal["closed", "shell"] = "closed") -> Solid:
    return Solid(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int32), kind)


def known_mass(body: Solid, category: str, names: list[str]) -> CategoryMassEstimate:
    return present(category_mass(body, category, names))


def can(scale: float = 1.0) -> Solid:
    return solid(trimesh.creation.cylinder(0.033 * scale, 0.1 * scale))


def cup(scale: float = 1.0) -> Solid:
    return solid(trimesh.creation.revolve(np.array(CUP) * scale, sections=64))


def test_every_category_has_usual_kinds_with_a_source():
    told = {row.category for row in category_masses() if not row.words}
    assert told == set(categories())
    assert all(0.0 < r.range[0] <= r.range[1] and r.weight > 0.0 and r.source for r in category_masses())


def test_one_kind_is_log_normal():
    one = NormalMixture(np.array([2.0]), np.array([0.3]), np.array([5.0]))
    low, high = one.central_interval(0.9)
    assert [one.quantile(0.5), low, high] == pytest.approx(
        [2.0, 2.0 + 0.3 * norm.ppf(0.05), 2.0 + 0.3 * norm.ppf(0.95)]
    )
    assert one.coverage_within(2.0 * 0.3 * float(norm.ppf(0.9)), 0.95) == pytest.approx(0.8, abs=1e-5)
    assert one.coverage_within(9.0, 0.95) == 0.95


def test_two_kinds_are_bounded_by_either():
    both = NormalMixture(np.array([0.0, 10.0]), np.array([0.1, 0.1]), np.array([3.0, 1.0]))
    low, high = both.central_interval(0.9)
    assert low == pytest.approx(0.1 * norm.ppf(0.05 / 0.75), abs=1e-6)
    assert high == pytest.approx(10.0 + 0.1 * norm.ppf(0.8), abs=1e-6)
    assert both.quantile(0.5) < 1.0


@pytest.mark.parametrize(("body", "category", "power"), [(can, "can", 3), (cup, "mug", 2)])
def test_contents_grow_with_the_volume_and_walls_with_the_area(body, category, power):
    one, two = known_mass(body(), category, []), known_mass(body(2.0), category, [])
    assert two.value_kg / one.value_kg == pytest.approx(2.0**power)
    assert two.high_kg / one.high_kg == pytest.approx(2.0**power)


def test_it_weighs_the_same_whatever_way_it_lies():
    turned = trimesh.creation.cylinder(0.033, 0.1)
    turned.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0, 0]))
    assert known_mass(solid(turned), "can", []).high_kg == pytest.approx(known_mass(can(), "can", []).high_kg)


def test_the_wall_of_a_cup_is_measured_once_however_it_is_modelled():
    """One side of wall and bottom: 2 pi r h + pi r2, from walls in the mesh and from a sheet."""
    area = 2.0 * np.pi * 0.0385 * 0.0985 + np.pi * 0.0385**2
    sheet = trimesh.creation.revolve(CUP[:3], sections=64)
    filled = trimesh.creation.cylinder(0.04, 0.1, sections=64)
    assert reference_size(cup(), "wall") == pytest.approx(area, rel=0.03)
    assert reference_size(solid(sheet, "shell"), "wall") == pytest.approx(area, rel=0.07)
    assert reference_size(solid(filled), "wall") == pytest.approx(area, rel=0.15)


def test_names_tell_the_kind_and_the_most_telling_name_decides():
    soup, chips = known_mass(can(), "can", ["005_tomato_soup_can"]), known_mass(can(), "can", ["chipsCan"])
    assert chips.high_kg < soup.low_kg
    assert known_mass(can(), "can", ["model", "soup", "chips"]) == known_mass(can(), "can", ["soup"])
    usual = known_mass(can(), "can", ["can"])
    assert usual.low_kg < chips.value_kg < soup.value_kg < usual.high_kg
    assert "full" in soup.text


def test_bounds_of_very_different_kinds_hold_less_and_say_so():
    found = known_mass(cup(), "cup", ["cup"])
    assert found.high_kg / found.low_kg == pytest.approx(MAX_CATEGORY_SPAN, rel=1e-4)
    assert 0.7 < found.coverage < 0.95
    assert f"{100 * found.coverage:.0f} % of things" in found.text


def test_own_rows_can_be_left_out():
    rows = masses_of_kind("can", [{"soup"}])
    assert {row.own_row_of for row in rows} == {"", "ycb 005"}
    assert all(row.own_row_of == "" for row in masses_of_kind("can", [{"soup"}], without="ycb 005"))


def test_a_category_outside_the_table_and_a_flat_body_say_nothing():
    flat = Solid(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]], dtype=np.int32), "shell")
    assert category_mass(can(), "spaceship", []) is None
    assert category_mass(flat, "plate", []) is None


def test_a_named_material_narrows_the_usual_mass_only_where_both_agree():
    usual = bounds_around(1.0, 0.5, 2.0, METRES, "mugs")
    near = bounds_around(1.0, 1.2, 1.6, METRES, "steel")
    assert (usual.intersected_with(near).low, usual.intersected_with(near).high) == pytest.approx((0.8, 2.0))
    far = usual.intersected_with(bounds_around(8.0, 7.0, 9.0, METRES, "steel"))
    assert (far.low, far.high) == (0.5, 2.0)
    assert "does not agree" in far.text


def test_mass_evidence_says_what_was_compared_and_widens_inertia_for_hollow_bodies():
    ball = solid(trimesh.creation.icosphere(subdivisions=3, radius=0.033))
    evidence = mass_evidence(
        ball, ["tennis_ball"], MassEvidenceInputs(category="ball", category_confidence=0.8, names=("tennis_ball",))
    )
    low, high = present(evidence.mass_kg.bounds)
    assert evidence.mass_kg.source == "inferred"
    assert 0.0 < evidence.mass_kg.confidence < 0.8
    assert low < 0.058 < high < 1.6 * low
    assert "things of category ball and this size, empty weigh" in evidence.mass_kg.method
    sheet = 2.0 / 3.0 * 0.058 * 0.033**2
    least, most = present(evidence.inertia_kgm2.bounds)
    assert least[0][0] < 0.4 * 0.058 * 0.033**2 < sheet < most[0][0]


def test_named_things_weigh_within_their_bounds_without_their_own_rows():
    rows = [weighed(thing, thing.name, without=thing.own_row_of) for thing in things()]
    known = [row for row in rows if row.category]
    assert len(known) >= 120
    assert sum(row.inside for row in known) >= 0.9 * len(known)
    assert all(row.width <= 1.001 * MAX_CATEGORY_SPAN for row in known)
    assert np.mean(np.log([row.width for row in known])) <= np.log(4.0)
