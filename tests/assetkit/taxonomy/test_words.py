"""Names become words whatever way they are written."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.taxonomy.words import singulars, words_of


@pytest.mark.parametrize(
    "name", ["coffee_mug", "CoffeeMug", "coffee-mug", "025_coffee mug.v2", "COFFEE_MUG", "Coffee.Mug.001"]
)
def test_one_name_in_many_spellings(name: str):
    assert words_of(name) == ("coffee", "mug")


def test_abbreviations_and_accents():
    assert words_of("USBStick") == ("usb", "stick")
    assert words_of("Küchenstuhl #2") == ("kuchenstuhl",)


def test_plurals():
    assert {"box", "boxe"} <= set(singulars("boxes"))
    assert "knife" in singulars("knives")
    assert "berry" in singulars("berries")
    assert singulars("glass") == ()
    assert singulars("mug") == ()


@given(st.text(max_size=200))
def test_any_name_gives_plain_words(name: str):
    assert all(word.isascii() and word.isalpha() and word.islower() and len(word) > 1 for word in words_of(name))
