"""Shells inside others, wound alike: filled or empty, and the record holds both readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.geometry.repair import repair_geometry
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from geom.mass.inertia import enclosed_volume
from geom.solid.nested_shells import nested_volume
from geom.solid.solidify import solidify
from tests.support.sample_surfaces import ball, box, inside_out, mesh_of, together

OUTER = box((1.0, 1.0, 1.0))
OFF_CENTRE = box((0.6, 0.6, 0.6), at=(0.15, 0.0, 0.1))


def test_what_lies_inside_counts_once() -> None:
    inner, beside = box((0.4, 0.2, 0.2)), box((0.4, 0.2, 0.2), at=(0.2, 0.0, 0.0))
    deeper, outside = box((0.1, 0.1, 0.1)), box((0.4, 0.4, 0.4), at=(0.5, 0.0, 0.0))
    held = nested_volume([deeper, OUTER, inner, beside, outside])
    assert held is not None
    assert held.volume_m3 == pytest.approx(0.6 * 0.2 * 0.2)
    assert held.centre_m == pytest.approx([0.1, 0.0, 0.0])
    assert nested_volume([OUTER, outside]) is None


def test_a_ball_in_a_hollow_box_is_not_inside_its_matter() -> None:
    hollow = together(OUTER, inside_out(box((0.8, 0.8, 0.8))))
    assert nested_volume([hollow, ball(0.3)]) is None


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (1e4, -2e3, 5e3)])
def test_both_readings_of_an_inner_shell_lie_within_the_bounds(shift) -> None:
    points, triangles = together(OUTER, OFF_CENTRE)
    mesh = mesh_of(points + np.asarray(shift), triangles)
    solid = solidify([mesh])[0]
    bounds = mass_evidence(solid, ["wood"], MassEvidenceInputs(meshes=(mesh,)))
    plain = mass_evidence(replace(solid, core=None), ["wood"], MassEvidenceInputs(meshes=(mesh,)))
    assert bounds.mass_kg.confidence == pytest.approx(0.5 * plain.mass_kg.confidence)
    assert "inner shell" in bounds.mass_kg.method
    empty = together(OUTER, inside_out(OFF_CENTRE))
    for reading in (OUTER, empty):
        body = enclosed_volume(reading[0] + np.asarray(shift), reading[1]).filled(bounds.density_kgm3.value)
        low, high = np.array(bounds.mass_kg.bounds)
        assert low <= body.mass_kg <= high * (1 + 1e-9)
        low, high = np.array(bounds.centre_of_mass_m.bounds)
        assert (low <= body.centre_of_mass_m).all()
        assert (body.centre_of_mass_m <= high).all()


def test_a_cavity_with_its_own_winding_and_a_part_of_another_material_are_in_no_doubt() -> None:
    assert solidify([mesh_of(*together(OUTER, inside_out(OFF_CENTRE)))])[0].core is None
    parts = [replace(mesh_of(*surface), material=i) for i, surface in enumerate((OUTER, OFF_CENTRE))]
    assert solidify(parts)[0].core is None
    assert solidify([replace(part, material=0) for part in parts])[0].core is not None


def test_the_doubt_is_told() -> None:
    result = repair_geometry([mesh_of(*together(OUTER, OFF_CENTRE))])
    note = next(d for d in result.diagnostics if d.code == "asset/overlapping-bodies")
    assert "cavity" in note.headline
    assert result.repairs[0].after["cavity_reading_m3"] == pytest.approx(1.0 - 0.6**3)
