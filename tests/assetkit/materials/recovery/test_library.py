"""The library: enough entries of each family, each plausible and with provenance."""

from __future__ import annotations

from collections import Counter

from assetkit.materials.recovery.families import thinnest_mm
from assetkit.materials.recovery.library import METALS, library
from assetkit.taxonomy.category_materials import class_names

LEAST_ENTRIES = 40  # the number
ALBEDO = (0.015, 0.96)  # linear: from velvet and tyres to toothpaste; light passes through clear bodies


def test_every_family_has_entries_and_every_class_is_known() -> None:
    assert len(library()) >= LEAST_ENTRIES
    assert {entry.material_class for entry in library()} == set(class_names())
    families = Counter(entry.family for entry in library())
    asked = ("metal", "plastic", "wood", "ceramic", "glass", "fabric", "paper", "food")
    assert all(families[name] >= 3 for name in asked), families
    assert len({entry.name for entry in library()}) == len(library())
    assert set(thinnest_mm()) <= set(class_names())


def test_entries_are_physically_plausible() -> None:
    """Metals are bare and bright, everything else is no metal, and its albedo is that of a real surface."""
    for entry in library():
        assert entry.metallic == float(entry.material_class in METALS), entry
        if entry.metallic:
            assert max(entry.base_color) >= 0.4, entry
        elif entry.transmission == 0.0:
            assert ALBEDO[0] <= max(entry.base_color) <= ALBEDO[1], entry


def test_every_entry_names_its_source_and_how_its_colour_is_known() -> None:
    """What is no estimate names a version, a file or a chart; most colours are published or measured."""
    basis = Counter(entry.colour_basis for entry in library())
    assert basis["generated"] == 0
    assert basis["published"] + basis["measured"] > basis["estimate"]
    for entry in library():
        assert entry.licence in ("CC0-1.0", "Apache-2.0")
        assert (entry.colour_basis == "estimate") == entry.source.startswith("estimate of the authors"), entry
