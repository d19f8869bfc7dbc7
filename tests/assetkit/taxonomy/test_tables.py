"""The vocabulary is complete, unambiguous and agrees with the other tables about the same things."""

from collections import Counter
from typing import get_args

import pytest

from assetkit.annotate.name_reading import category_by_name, read_name
from assetkit.taxonomy.material_classes import materials
from assetkit.taxonomy.tables import Category, categories, families, fillers, interaction_groups, other_things
from assetkit.taxonomy.words import words_of
from gate.subject.category import category_sizes, known_category
from schemas.asset import Role

ALL = list(categories().values())


def named(category: Category) -> tuple[str, ...]:
    return (*category.aliases, *category.weak_aliases)


def test_counts():
    tabletop = [c for c in ALL if c.scope == "tabletop"]
    assert len(tabletop) == 44
    assert len({c.family for c in tabletop}) == 10
    assert len(interaction_groups()) == 9


def test_references_between_the_tables_exist():
    assert {c.family for c in ALL} == set(families())
    assert all(families()[c.family].scope == c.scope for c in ALL)
    assert {c.group for c in ALL} - {""} <= set(interaction_groups())
    assert {m for c in ALL for m in c.materials} <= set(materials())


def test_every_role_is_used_or_left_to_scenes():
    used = {role for c in ALL for role in c.roles} | {r for g in interaction_groups().values() for r in g.roles}
    assert used == set(get_args(Role))


def test_aliases_are_unique_whatever_way_they_are_written():
    written = Counter("".join(words_of(name)) for c in ALL for name in named(c))
    assert [name for name, count in written.items() if count > 1] == []
    assert not set(written) & {"".join(words_of(name)) for name in other_things()}


@pytest.mark.parametrize("category", ALL, ids=lambda c: c.id)
def test_a_row_holds_together(category: Category):
    for low, high in (*category.extents_m, category.mass_kg, *([category.fill] if category.fill else [])):
        assert 0.0 <= low < high
    lows, highs = zip(*category.extents_m, strict=True)
    assert sorted(lows) == list(lows)
    assert sorted(highs) == list(highs)
    assert category.roles
    assert category.parts
    assert category.source
    assert category_by_name(category.id) is category
    assert all(read_name(name).category == category.id for name in named(category))
    level = {"leaf": category.qcode, "family": families()[category.family].qcode, "object": "Q488383"}
    assert category.qcode == level[category.qcode_level] or category.id == "pill_bottle"  # A bottle, as its class says.


@pytest.mark.parametrize("category", [c for c in ALL if known_category(c.id)], ids=lambda c: c.id)
def test_what_is_said_to_be_a_category_is_not_refused_by_the_gate_for_its_size(category: Category):
    """The gate gives an error beyond 3 times its own range; things of a usual size stay well within."""
    known = known_category(category.id)
    assert known is not None
    least_m, most_m = category_sizes()[known]
    low, high = category.large_m
    assert low >= least_m / 3.0
    assert high <= most_m * 3.0


def test_fillers_name_no_unmistakable_thing():
    """A colour may be a fruit as well; nothing else that is left out may be a thing."""
    clear = {"".join(words_of(name)) for c in ALL for name in c.aliases}
    assert not clear & fillers()


def test_densities_of_mass_and_size_are_of_this_world():
    """No thing in the table is lighter than foam in its smallest box or heavier than steel in its largest."""
    for category in ALL:
        small, large = (category.small_m[i] * category.middle_m[i] * category.large_m[i] for i in (0, 1))
        assert category.mass_kg[0] < 8000.0 * large, category.id
        assert category.mass_kg[1] > 10.0 * small, category.id
