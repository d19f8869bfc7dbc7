"""Recovery fills in open values alone, as sure as its evidence, and the same each time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from assetkit.materials.recovery.degraded import RECOVERABLE, degradation, is_default_grey, trusted
from assetkit.materials.recovery.families import MOST_WITHOUT_NAME
from assetkit.materials.recovery.rank import DrawnSurface
from assetkit.materials.recovery.recover import recover
from assetkit.materials.recovery.surfaces import RecoverySubject
from assetkit.taxonomy.tables import categories
from schemas.appearance.material import Material, Origin, TextureUse
from schemas.appearance.record import DegradedReason
from schemas.evidence import Evidence, declared
from schemas.model import Model
from tests.assetkit.materials.recovery.samples import MUG, UNKNOWN, box, model_of, subject

RED = (0.6, 0.05, 0.05)
SHARES = st.floats(0.0, 1.0)
COLOURS = st.one_of(st.just((0.8, 0.8, 0.8)), st.just((1.0, 1.0, 1.0)), st.tuples(SHARES, SHARES, SHARES))
ORIGINS = st.builds(Origin, st.sampled_from(("declared", "measured", "inferred", "default")), st.just("source"), SHARES)
NAMES = st.sampled_from(("Material", "lambert1", "steel", "red paint", "oak", "", "label"))


@st.composite
def materials(draw: st.DrawFn) -> Material:
    fields: st.SearchStrategy[str] = st.sampled_from((*RECOVERABLE, "emissive", "clearcoat"))
    origins: dict[str, Origin] = draw(st.dictionaries(fields, ORIGINS))
    lost = draw(st.sampled_from(((), ("base_color_texture",))))
    maps = draw(st.sampled_from((None, TextureUse("absent"))))
    return Material(
        draw(NAMES),
        base_color=draw(COLOURS),
        base_color_texture=maps,
        metallic=draw(SHARES),
        roughness=draw(SHARES),
        emissive=draw(COLOURS),
        clearcoat=draw(SHARES),
        ior=draw(st.floats(1.0, 2.0)),
        transmission=draw(SHARES),
        origins=origins,
        lost_textures=lost,
    )


@settings(deadline=None, max_examples=150)
@given(st.lists(materials(), min_size=1, max_size=3), st.sampled_from(("unknown", *categories())), SHARES)
def test_no_trustworthy_value_changes(listed: list[Material], category: str, confidence: float) -> None:
    """Whatever the source states: values and origins that can be trusted stay, so do fields that are never recovered,
    and what is new is inferred or a default.
    """
    model = model_of([box(f"part_{i}", i, 0.2 * i) for i in range(len(listed))], listed)
    known = Evidence[str](value=category, source="inferred", confidence=confidence)
    recovered = recover(model, subject(known)).model
    for mesh, before in zip(recovered.meshes, listed, strict=True):
        assert mesh.material is not None
        after = recovered.materials[mesh.material]
        changed = {
            f
            for f in RECOVERABLE
            if after.origins.get(f) != before.origins.get(f) or getattr(after, f) != getattr(before, f)
        }
        assert not {field for field in changed if trusted(before, field)} - excepted(before)
        assert all(after.origins[f].source in ("inferred", "default") for f in changed)
        assert all(after.origins[f].confidence <= MOST_WITHOUT_NAME for f in changed if not _names_material(before))
        untouched = replace(after, **{f: getattr(before, f) for f in RECOVERABLE}, origins=before.origins)
        assert untouched == before


def excepted(material: Material) -> set[str]:
    """What a tool states for an author who states nothing: its grey, and the factor beside a lost picture."""
    reason = degradation(material, set())
    if not is_default_grey(material.base_color):
        return set()
    if reason is DegradedReason.LOST_TEXTURE:
        return {"base_color"}
    return {"base_color", "metallic", "roughness"} if reason is DegradedReason.DEFAULT_GREY else set()


def _names_material(material: Material) -> bool:
    return material.name in ("steel", "oak")


def test_a_model_without_degraded_surfaces_is_the_same_object() -> None:
    model = model_of(
        [box("body", 0)], [Material("red", base_color=RED, origins={"base_color": Origin("declared", "Kd")})]
    )
    assert recover(model, subject(MUG)).model is model


def recovered_family(model: Model, known: RecoverySubject) -> Evidence[str]:
    return recover(model, known).surfaces[0].family


def test_the_category_alone_is_never_surer_than_a_half() -> None:
    family = recovered_family(model_of([box("body")]), subject(MUG))
    assert (family.value, family.source) == ("ceramic", "inferred")
    assert 0.3 < family.confidence <= MOST_WITHOUT_NAME


def test_a_name_on_the_surface_is_strong_evidence_and_that_of_the_file_is_not() -> None:
    named = recovered_family(model_of([box("steel_body")]), subject(MUG))
    assert named.value == "metal"
    assert named.confidence > MOST_WITHOUT_NAME
    of_file = recovered_family(model_of([box("body")]), subject(UNKNOWN, "steel_thing"))
    assert (of_file.value, of_file.confidence) == ("metal", MOST_WITHOUT_NAME)
    part = recovered_family(model_of([box("steel_thing_handle")]), subject(UNKNOWN, "steel_thing"))
    assert part.confidence <= MOST_WITHOUT_NAME


def test_without_any_clue_the_family_is_a_default() -> None:
    family = recovered_family(model_of([box("a")]), replace(subject(UNKNOWN, "a"), is_metric=False))
    assert (family.source, family.confidence) == ("default", 0.0)


def test_density_and_walls_count() -> None:
    """A box as dense as steel is one; a closed sheet of 0.2 mm is no glass."""
    dense = replace(subject(UNKNOWN, "a"), densities_kgm3={"a": 7800.0})
    assert recovered_family(model_of([box("a")]), dense).value == "metal"
    sheet = replace(box("a"), points=box("a").points * (1.0, 1.0, 0.002))
    glass = declared("drinking_glass", "test", confidence=0.6)
    thick, thin = (recovered_family(model_of([mesh]), subject(glass, "a")) for mesh in (box("a"), sheet))
    assert (thick.value, thin.value) == ("glass", "plastic")


def test_parts_of_one_material_are_told_apart_and_keep_what_is_stated() -> None:
    """One grey material on a steel blade and a wooden handle becomes two; its emission stays on both."""
    shared = Material("Material", emissive=(0.1, 0.0, 0.0), origins={"emissive": Origin("declared", "Ke")})
    result = recover(model_of([box("steel_blade", 0), box("wooden_grip", 0, 0.2)], [shared]), subject())
    families = [surface.family.value for surface in result.surfaces]
    assert families == ["metal", "wood"]
    first, second = (result.model.materials[mesh.material or 0] for mesh in result.model.meshes)
    assert first.name == "Material"
    assert second.name == "Material_wood_medium"
    assert first.emissive == second.emissive == (0.1, 0.0, 0.0)


def test_a_named_colour_chooses_the_entry() -> None:
    result = recover(model_of([box("red_plastic_lid")]), subject())
    assert result.surfaces[0].entry == "plastic_red"


def test_a_word_chooses_the_entry_in_the_likeliest_family_alone() -> None:
    fruit = recover(model_of([box("body")]), subject(declared("fruit", "test"), "banana"))
    assert fruit.surfaces[0].entry == "banana"
    toy = recover(model_of([box("plastic_body")]), subject(declared("block", "test"), "lego_brick"))
    assert toy.surfaces[0].family.value == "plastic"


def test_surfaces_of_one_class_take_one_entry() -> None:
    """The lid looks better in black, the body much better in white: both become white."""

    def draw(
        model: Model, variants: Sequence[Sequence[Material]], regions: Sequence[int]
    ) -> list[list[DrawnSurface | None]]:
        dark = [materials[regions[0]].base_color[0] < 0.1 for materials in variants]
        return [
            [
                DrawnSurface(0.04 if is_dark else 0.03, 0.0, None, {}),
                DrawnSurface(0.01 if is_dark else 0.08, 0.0, None, {}),
            ]
            for is_dark in dark
        ]

    meshes = [box("plastic_lid"), box("plastic_body", at_m=0.2)]
    result = recover(model_of(meshes), subject(declared("block", "test")), draw)
    assert [surface.entry for surface in result.surfaces] == ["plastic_white", "plastic_white"]
    assert len({mesh.material for mesh in result.model.meshes}) == 1


@pytest.mark.parametrize(("best", "expected"), [(0, "plastic_white"), (1, "plastic_black")])
def test_pictures_choose_between_what_is_equally_likely_and_not_against_it(best: int, expected: str) -> None:
    """Black and white plastic are as usual; the one whose shape is seen wins. A metal does not win by looks."""

    def draw(
        model: Model, variants: Sequence[Sequence[Material]], regions: Sequence[int]
    ) -> list[list[DrawnSurface | None]]:
        dark = [materials[regions[0]].base_color[0] < 0.1 for materials in variants]
        metal = [materials[regions[0]].metallic == 1.0 for materials in variants]
        seen = [
            0.08 if is_metal or is_dark == bool(best) else 0.01 for is_dark, is_metal in zip(dark, metal, strict=True)
        ]
        return [[DrawnSurface(contrast, 0.0, None, {})] for contrast in seen]

    block = declared("block", "test")
    result = recover(model_of([box("plastic_body")]), subject(block), draw)
    assert result.surfaces[0].entry == expected
    best_terms = result.surfaces[0].candidates[0].terms
    assert result.surfaces[0].candidates[0].score == pytest.approx(sum(best_terms.values()), abs=1e-3)


def test_the_same_input_gives_the_same_result() -> None:
    model = model_of([box("body"), box("lid", at_m=0.2)])
    assert recover(model, subject(MUG)).surfaces == recover(model, subject(MUG)).surfaces
