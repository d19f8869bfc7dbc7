"""The embedded annotator takes categories from names, weakens those that the shape contradicts, else gives none."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.annotate.annotator import MIN_SCORE, UNKNOWN, ObjectShape, Observation
from assetkit.annotate.embedded import EmbeddedAnnotator

MUG = ObjectShape((0.08, 0.085, 0.115), 0.6, 0.8)
ANNOTATE = EmbeddedAnnotator().annotate


def seen(
    shape: ObjectShape = MUG, *, file: str = "part", folder: str = "", shared: bool = False, **names: str
) -> Observation:
    words = {key: tuple(text.split()) for key, text in names.items()}
    nodes, materials, titles = (words.get(key, ()) for key in ("nodes", "materials", "titles"))
    return Observation(file, (folder,) if folder else (), nodes, materials, titles, shape, shared)


@pytest.mark.parametrize(
    "evidence",
    [
        seen(file="025_mug"),
        seen(file="textured", folder="025_mug"),
        seen(file="model", nodes="root coffee_mug handle"),
        seen(file="scene", titles="CoffeeMug"),
    ],
)
def test_one_good_name_that_fits_is_enough(evidence: Observation):
    found = ANNOTATE(evidence)
    assert found.category == "mug"
    assert found.score > MIN_SCORE
    assert any("mug" in clue for clue in found.hypotheses[0].clues)


def test_size_contradicts_a_name_and_is_told():
    found = ANNOTATE(seen(ObjectShape((2.0, 2.2, 3.0), 0.6, 0.8), file="mug"))
    assert found.category == UNKNOWN
    assert found.hypotheses[0].category == "mug"
    assert found.hypotheses[0].score < 0.2
    assert "3 m is" in found.contradictions[0]


def test_a_faint_name_that_does_not_fit_is_no_contradiction():
    assert ANNOTATE(seen(ObjectShape((1.0, 1.0, 1.0), 1.0, 0.0), file="clutch_plate")).contradictions == ()


def test_a_part_is_not_the_whole_although_the_folder_names_it():
    assert ANNOTATE(seen(file="handle", folder="mug")).category == UNKNOWN
    assert ANNOTATE(seen(file="microdoor", folder="microwave")).category == UNKNOWN


def test_links_of_a_mechanism_that_is_another_thing_are_parts_of_it():
    pans = seen(ObjectShape((0.16, 0.21, 0.36), 0.5, 0.9), file="balance_scale", nodes="base beam pan_left pan_right")
    assert ANNOTATE(replace(pans, articulated=True)).hypotheses == ()
    assert ANNOTATE(pans).hypotheses[0].category == "pan"
    unit = seen(ObjectShape((0.4, 0.45, 0.5), 0.9, 0.6), file="drawer_unit", nodes="body drawer_1 drawer_2")
    confirmed = ANNOTATE(replace(unit, articulated=True))
    assert confirmed.category == "cabinet"
    assert any("node name 'drawer_1'" in clue for clue in confirmed.hypotheses[0].clues)


def test_names_that_disagree_leave_it_open():
    found = ANNOTATE(seen(file="model", nodes="mug cup"))
    assert found.category == UNKNOWN
    assert {h.category for h in found.hypotheses} == {"mug", "cup"}


def test_the_same_word_said_twice_counts_once_and_another_word_adds():
    once = ANNOTATE(seen(file="mug")).score
    assert ANNOTATE(seen(file="mug", folder="mug", nodes="mug_01", materials="mug")).score == once
    assert ANNOTATE(seen(file="mug", nodes="coffee_mug")).score > once


def test_a_file_of_many_things_speaks_less_of_each():
    assert ANNOTATE(seen(file="mugs_and_more")).score >= ANNOTATE(seen(file="mugs_and_more", shared=True)).score


def test_names_of_modelling_tools_say_nothing():
    cube = ObjectShape((0.05, 0.05, 0.05), 1.0, 0.0)
    assert ANNOTATE(seen(cube, nodes="Cube.001 Box Cylinder_2", materials="Material.001")).hypotheses == ()


@given(
    st.tuples(*[st.floats(1e-3, 10.0)] * 3).map(lambda e: tuple(sorted(e))),
    st.floats(0.05, 1.0),
    st.floats(0.0, 1.0),
)
def test_without_names_nothing_is_ever_said(extents, fill, hollow):
    assert ANNOTATE(seen(ObjectShape(extents, fill, hollow))).category == UNKNOWN
