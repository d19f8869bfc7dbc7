"""The material table is sound, and names point to materials by whole words only."""

from __future__ import annotations

import pytest

from assetkit.taxonomy.material_classes import UNKNOWN, contacts_of, material_for, materials
from schemas.evidence import default
from tests.support.present import present


@pytest.mark.parametrize("material", materials().values(), ids=lambda m: m.name)
def test_every_row_is_physical_and_has_a_source(material):
    low, high = material.density_bounds_kgm3
    assert 0 < low <= material.density_kgm3 <= high <= 30 * low
    assert 0 < material.dynamic_friction <= material.static_friction
    assert material.friction_bounds[0] <= material.dynamic_friction
    assert material.static_friction <= material.friction_bounds[1]
    assert 0 <= material.restitution_bounds[0] <= material.restitution <= material.restitution_bounds[1] <= 1
    assert len(material.source) > 20


def test_no_word_stands_for_two_materials():
    words = [word for m in materials().values() for word in m.words]
    assert len(words) == len(set(words))
    assert all(word.islower() and word.isalpha() for word in words)


@pytest.mark.parametrize("name", sorted(materials()))
def test_contacts_start_with_any_and_every_pair_is_physical(name):
    contacts = contacts_of(default(name))
    assert [c.value.counterpart for c in contacts].count("any") == 1
    assert contacts[0].value.counterpart == "any"
    for evidence in contacts:
        contact, (low, high) = evidence.value, present(evidence.bounds)
        assert contact.counterpart in {*materials(), "any"}
        assert low.static_friction <= contact.dynamic_friction <= contact.static_friction <= high.static_friction
        assert low.restitution <= contact.restitution <= high.restitution
        assert low.dynamic_friction <= low.static_friction
        assert high.dynamic_friction <= high.static_friction


def test_a_pair_reads_the_same_from_both_sides():
    seen_from_wood = {c.value.counterpart: c.value.static_friction for c in contacts_of(default("wood"))}
    seen_from_steel = {c.value.counterpart: c.value.static_friction for c in contacts_of(default("steel"))}
    assert seen_from_wood["steel"] == seen_from_steel["wood"]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["painted_wooden_stool"], "wood"),
        (["RubberDuck"], "rubber"),
        (["061_foam_brick"], "foam"),
        (["scan_42", "Material.001", "Stainless-Steel_brushed"], "steel"),
        (["MATTE_PLASTIC"], "plastic"),
        (["glasses"], UNKNOWN),  # part of a word is no word
        (["woodpecker", "mug", "Material"], UNKNOWN),
        ([], UNKNOWN),
    ],
)
def test_names_point_to_materials(names, expected):
    assert material_for(names).value == expected


def test_confidence_is_low_lower_when_disputed_and_zero_when_unknown():
    sure = material_for(["wooden_box", "oak"])
    disputed = material_for(["wooden_box", "oak", "steel_hinge"])
    unknown = material_for(["thing"])
    assert sure.value == disputed.value == "wood"
    assert unknown.confidence == 0.0 < disputed.confidence < sure.confidence < 0.5
    assert (unknown.source, sure.source) == ("default", "inferred")
    assert sure.inputs == ("wooden_box", "oak")


def test_a_repeated_name_votes_once():
    assert material_for(["mesh_glass", "mesh_glass", "mesh_glass", "oak", "pine"]).value == "wood"
