"""Bounds of mass: as wide as what is unknown, no wider than a factor of 30, and they say why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from assetkit.mass.bounds import MAX_SPAN, MassBounds
from assetkit.mass.estimate import MassEvidence, mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.mass.unknown_density import dense_appearance
from benchmarks.assets.masses.everyday import bounds_kg, things
from schemas.appearance.material import Material
from schemas.evidence import inferred
from schemas.model import Mesh
from schemas.physics import Solid
from tests.support.mass_samples import ball, box, inside_out, join_meshes, weighed
from tests.support.package_samples import mesh_from
from tests.support.present import present

CUBE = (0.2, 0.2, 0.2)


def cup_profile(wall: float) -> Mesh:
    r, h = 0.04, 0.1
    profile = [[0, 0], [r, 0], [r, h], [r - wall, h], [r - wall, wall], [0, wall]]
    return mesh_from(trimesh.creation.revolve(profile, sections=64), "cup")


def span(evidence: MassEvidence) -> float:
    low, high = present(evidence.mass_kg.bounds)
    return high / low


def test_a_closed_can_may_be_hollow_but_a_modelled_wall_is_full():
    """The same can in plastic: as a scan of its outside, and with its wall in the mesh."""
    outside = mesh_from(trimesh.creation.cylinder(0.04, 0.1), "can")
    scan, _, _ = weighed([outside], file="plastic_can.obj")
    mug, canonical, _ = weighed([cup_profile(0.003)], file="plastic_mug.obj")
    wall = 0.003 * outside_area() * 890.0
    assert "may be hollow" in scan.mass_kg.method
    low, high = present(scan.mass_kg.bounds)
    assert low < wall < high
    assert "hollow" not in mug.mass_kg.method
    assert span(mug) < 2.0 < 10.0 < span(scan)
    assert present(mug.mass_kg.bounds)[0] == pytest.approx(890.0 * canonical.section.volume_m3.value)


def outside_area() -> float:
    return float(trimesh.creation.cylinder(0.04, 0.1).area)


def test_an_inner_shell_shows_the_wall_too():
    hollow = join_meshes(ball(0.05, subdivisions=3), inside_out(ball(0.047, subdivisions=3)))
    found, _, _ = weighed([hollow], file="plastic_ball.obj")
    full, _, _ = weighed([ball(0.05, subdivisions=3)], file="plastic_ball.obj")
    assert span(found) < 2.0 < span(full)


def test_unknown_material_is_wide_and_says_so():
    found, _, _ = weighed([box(CUBE)], file="thing.obj")
    assert found.mass_kg.source == "default"
    assert found.mass_kg.confidence == 0.0
    assert "material unknown" in found.mass_kg.method
    assert "may be hollow" in found.mass_kg.method
    heavy, light = ("brass", "lead", "gold", "steel", "aluminium", "stone"), ("empty packaging", "foam")
    assert f"outside: {', '.join([*(f'solid {name}' for name in heavy), *light])}" in found.mass_kg.method
    assert span(found) == pytest.approx(MAX_SPAN)


def test_density_of_the_unknown_falls_with_the_root_of_size_and_ends_at_steel():
    sizes_m = np.array([0.005, 0.01, 0.1, 0.4, 1.6])
    found = [weighed([box((size,) * 3)], file="thing.obj")[0].density_kgm3 for size in sizes_m]
    assert [f.value for f in found[2:]] == pytest.approx([500.0, 250.0, 125.0])
    assert found[0].bounds == found[1].bounds == pytest.approx((8100.0 / MAX_SPAN, 8100.0))
    assert all(f.source == "default" and (b := present(f.bounds))[1] / b[0] == pytest.approx(MAX_SPAN) for f in found)


def test_blocks_of_palm_size_may_be_of_plastic_wood_or_aluminium_and_with_bare_metal_of_steel():
    size = (0.06, 0.04, 0.025)
    volume = float(np.prod(size))
    painted = Material("a", metallic=0.0)
    silent = Material("b", metallic=1.0, roughness=1.0)  # what glTF means by saying nothing
    metal = Material("c", metallic=1.0, roughness=0.4)
    block = replace(box(size), material=0)
    plain = weighed([block], materials=[painted], file="thing.obj")[0].mass_kg
    assert weighed([block], materials=[silent], file="thing.obj")[0].mass_kg == plain
    shown = weighed([block], materials=[metal], file="thing.obj")[0].mass_kg
    plain_bounds, shown_bounds = present(plain.bounds), present(shown.bounds)
    for density in (400.0, 1050.0, 2700.0):
        assert plain_bounds[0] < density * volume < plain_bounds[1]
        assert shown_bounds[0] < density * volume < shown_bounds[1]
    assert plain_bounds[1] < 7850.0 * volume < shown_bounds[1]
    assert "metallic surface" in shown.method
    assert "solid steel" in plain.method


def test_a_part_in_stl_is_drawn_with_its_walls():
    assert dense_appearance("stl", (), ()) == "part in STL"
    assert dense_appearance("obj", (), ()) == ""


def test_most_everyday_things_weigh_within_their_bounds():
    """Names untold; solid stone and large iron stay outside from above, empty packaging and foam from below."""
    table = list(things())
    inside = [t for t in table if (b := bounds_kg(t, with_metal=True))[0] <= t.mass_kg <= b[1]]
    assert len(inside) >= 0.85 * len(table)


def test_unknown_plates_and_rods_are_full_of_it():
    found, _, _ = weighed([box((0.3, 0.2, 0.004))], file="thing.obj")
    assert found.mass_kg.bounds == pytest.approx((270 * 0.3 * 0.2 * 0.004, 8000 * 0.3 * 0.2 * 0.004))
    assert "hollow" not in found.mass_kg.method


def test_a_provisional_unit_widens_the_bounds_by_its_cube():
    sure, _, _ = weighed([box(CUBE)])
    unit = inferred(1.0, "a guess", 0.7, bounds=(0.9, 1.2))
    unsure, _, _ = weighed([box(CUBE)], unit=unit)
    low, high = present(sure.mass_kg.bounds)
    assert unsure.mass_kg.bounds == pytest.approx((low * 0.9**3, high * 1.2**3))
    assert "unit provisional" in unsure.mass_kg.method
    assert present(unsure.centre_of_mass_m.bounds)[1][2] == pytest.approx(1.2 * 0.1 + 0.05 * 0.2)
    assert unsure.mass_kg.confidence < sure.mass_kg.confidence


def test_a_unit_that_may_be_off_by_a_thousand_is_cut_and_said():
    found, _, _ = weighed([box(CUBE)], unit=inferred(1.0, "a guess", 0.7, bounds=(1e-3, 1.0)))
    assert span(found) == pytest.approx(MAX_SPAN)
    assert "true spread 2.71e+09x, cut to 30x" in found.mass_kg.method
    assert present(found.mass_kg.bounds)[1] == pytest.approx(950.0 * 0.008)  # The material's own spread stays whole.


def test_parts_that_name_no_material_widen_the_bounds():
    parts = (box((0.1, 0.1, 0.1), (-0.05, 0, 0), "oak_block"), box((0.1, 0.1, 0.1), (0.05, 0, 0), "steel_block"))
    unnamed = (parts[0], replace(parts[1], name="block"))
    known, _, _ = weighed(parts, file="thing.obj")
    partly, _, _ = weighed(unnamed, file="thing.obj")
    assert [p.material.value for p in known.parts] == ["wood", "steel"]
    assert [p.material.value for p in partly.parts] == ["wood", "unknown"]
    assert [p.volume_share for p in known.parts] == pytest.approx([0.5, 0.5])
    assert [p.mass_share for p in known.parts] == pytest.approx([650 / 8500, 7850 / 8500])
    assert known.density_kgm3.value == pytest.approx(4250.0)
    assert known.density_kgm3.method.startswith("effective")
    assert partly.mass_kg.source == "inferred"
    assert partly.mass_kg.confidence < known.mass_kg.confidence
    assert "material unknown" in partly.mass_kg.method


def test_shares_that_only_the_paint_tells_could_be_any_of_the_materials():
    cup = cup_profile(0.004)
    centres = cup.points[cup.triangles].mean(axis=1)
    inner = (np.hypot(centres[:, 0], centres[:, 1]) < 0.0365) & (centres[:, 2] > 0.003)
    parts = [
        Mesh("steel", cup.points, cup.triangles[~inner]),
        Mesh("plastic", cup.points, cup.triangles[inner]),
    ]
    found, canonical, _ = weighed(parts, file="cup.obj")
    volume = canonical.section.volume_m3.value
    assert "visible area" in found.mass_kg.method
    assert found.mass_kg.bounds == pytest.approx((890.0 * volume, 8100.0 * volume))


def test_what_a_category_weighs_cuts_the_bounds_but_never_past_the_estimate():
    wide = MassBounds(0.1, 3.0, ("material unknown",), 60.0)
    cut = wide.clipped_to((0.2, 1.5), "cans weigh 0.2 to 1.5 kg", 0.5)
    assert (cut.low, cut.high) == (0.2, 1.5)
    assert cut.span == pytest.approx(60.0 * (1.5 / 0.2) / 30.0)
    assert "cans weigh" in cut.text
    assert wide.clipped_to((0.2, 0.4), "", 0.5).high == 0.5
    assert wide.clipped_to((0.01, 30.0), "", 0.5) == wide
    assert wide.clipped_to((4.0, 9.0), "", 0.5) == wide


def test_a_category_that_no_such_body_can_have_is_told_and_changes_nothing():
    cube = trimesh.creation.box((0.05, 0.05, 0.05))
    body = Solid(np.asarray(cube.vertices), cube.faces.astype(np.int32), "closed")
    plain = mass_evidence(body, ["part"], MassEvidenceInputs())
    told = mass_evidence(body, ["part"], MassEvidenceInputs(category="sofa", category_range_kg=(15.0, 200.0)))
    assert told.mass_kg.bounds == plain.mass_kg.bounds
    assert [d.code for d in told.diagnostics] == ["asset/category-contradicted"]
    fits = mass_evidence(body, ["part"], MassEvidenceInputs(category="block", category_range_kg=(0.02, 0.2)))
    assert fits.mass_kg.source == "inferred"
    assert fits.mass_kg.bounds is not None
    assert fits.mass_kg.bounds[0] == 0.02
    assert "block weigh 0.02 to 0.2 kg" in fits.mass_kg.method
