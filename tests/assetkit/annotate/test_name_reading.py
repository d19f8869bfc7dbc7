"""The head of a name is what the thing is; words inside other words and other things are not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.annotate.name_reading import CLEAR, FAINT, LIKELY, category_by_name, read_name


@pytest.mark.parametrize(
    ("name", "category"),
    [
        ("025_mug", "mug"),
        ("scissors_v2", "scissors"),
        ("chefmate_8_frypan", "pan"),
        ("010_potted_meat_can_textured", "can"),
        ("WaterBottle", "bottle"),
        ("bottle_of_water", "bottle"),
        ("orange_cup", "cup"),
        ("cup_orange", "cup"),
        ("glass_table", "table"),
        ("frying-pan", "pan"),
        ("fryingpan_low_poly", "pan"),
        ("toy_car", "toy_vehicle"),
        ("apple_red", "fruit"),
        ("fruit bowl", "bowl"),
        ("tomato_soup_can", "can"),
        ("book_shelf", "shelf"),
        ("Room_Essentials_Mug_White_Yellow", "mug"),
        ("ycb_001_chips_can_urdf_missingmesh", "can"),
        ("mug_lowpolymesh", "mug"),
    ],
)
def test_clear_names(name: str, category: str):
    found = read_name(name)
    assert (found.category, found.strength) == (category, CLEAR)


@pytest.mark.parametrize(
    "name", ["tablecloth", "table_cloth", "scan_02", "candle", "bowling", "mug_holder", "bottle_cap", "MousePad", "key"]
)
def test_words_in_other_words_and_other_things(name: str):
    assert read_name(name).category is None


@pytest.mark.parametrize(
    ("name", "category", "strength"),
    [
        ("Cole_Hardware_Bowl_Scirocco", "bowl", LIKELY),  # An unknown word behind the noun.
        ("plate", "plate", LIKELY),  # Of steel or of china.
        ("bowl_avocado", "bowl", LIKELY),  # A colour or what lies in it, not the thing.
        ("teapots", "teapot", LIKELY),  # Several things, perhaps.
        ("clutch_plate", "plate", FAINT),  # An ambiguous noun behind an unknown word.
        ("peaches", "fruit", FAINT),  # As likely the name on a can.
        ("pencil_24_count", "pen", LIKELY),  # The package of them.
        ("Coffee_Mug_Kristen_16_oz_cup", "cup", LIKELY),  # Two things named.
    ],
)
def test_doubtful_names_count_less(name: str, category: str, strength: float):
    found = read_name(name)
    assert (found.category, found.strength) == (category, strength)


@pytest.mark.parametrize(
    "name",
    ["textured_simple_reoriented", "mesh_0", "google_16k", "", "123", "part_left", "newmodel", "meshexport_final"],
)
def test_jargon_is_silence(name: str):
    assert read_name(name).is_uninformative


def test_what_users_call_a_category():
    for stated in ("mug", "Coffee mugs", "coffee_mug"):
        found = category_by_name(stated)
        assert found is not None
        assert found.id == "mug"
    assert category_by_name("armadillo") is None
    assert category_by_name("mug holder") is None
    assert category_by_name("") is None


@given(st.text(max_size=200))
def test_any_text_can_be_read(name: str):
    found = read_name(name)
    assert (found.category is None) == (found.strength == 0.0)
