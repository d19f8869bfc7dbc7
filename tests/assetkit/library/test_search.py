"""Requests are read as the words mean, and assets are found for reasons that can be checked."""

from __future__ import annotations

import sqlite3
import unicodedata
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.library import catalog
from assetkit.library.catalog.migrations import VERSION
from assetkit.library.search import facts
from assetkit.library.search.facts import Facts, RatedValue
from assetkit.library.search.parse_query import parse_query
from assetkit.library.search.query import Criterion
from assetkit.library.search.search import SearchResult, search
from assetkit.materials.colour_names import BASIC_TERMS, basic_terms, colour_by_name
from assetkit.materials.surface_colours import surface_colours
from schemas.appearance.material import Material
from schemas.diagnostics import InvalidInput
from schemas.evidence import default
from schemas.model import Mesh, Model

INF = float("inf")


def read(request: str) -> dict[str, object]:
    """Field -> values, or limits, of what a request is read as."""
    return {w.field: w.values or (w.low, w.high) for w in parse_query(request)}


@pytest.mark.parametrize(
    ("request_", "meaning"),
    [
        ("red mug I can pour from", {"category": ("mug",), "colour": ("red",), "task": ("pour",)}),
        ("Coffee Mugs", {"category": ("mug",)}),
        ("a mug or a bowl", {"category": ("mug", "bowl")}),
        ("glass bottle", {"category": ("bottle",)}),
        ("wooden tray", {"category": ("tray",), "material": ("wood",)}),
        ("teal drinkware", {"family": ("drinkware",), "colour": (colour_by_name("teal"),)}),
        ("an orange", {"category": ("fruit",)}),
        ("orange mug", {"category": ("mug",), "colour": ("orange",)}),
        ("bowl for fruit", {"category": ("bowl",), "text": ("fruit",)}),
        ("mug with a handle", {"category": ("mug",), "part": ("handle",)}),
        ("receptacle under 10 cm", {"role": ("receptacle",), "size_m": (0.0, 0.1)}),
        ("box between 2 and 4 inches", {"category": ("box",), "size_m": (0.0508, 0.1016)}),
        ("bottle at least 0,2 kg", {"category": ("bottle",), "mass_kg": (0.2, INF)}),
        ("vase taller than 20cm", {"category": ("vase",), "height_m": (0.2, INF)}),
        ("can", {"category": ("can",)}),
        ("a container", {"family": ("containers",)}),
        ("mug no more than 10 cm", {"category": ("mug",), "size_m": (0.0, 0.1)}),
        ("mug not taller than 10 cm", {"category": ("mug",), "height_m": (0.0, 0.1)}),
        ("mug not under 10 cm", {"category": ("mug",), "size_m": (0.1, INF)}),
        ("box between 5cm and 8 cm", {"category": ("box",), "size_m": (0.05, 0.08)}),
        ("table 1 m to 80 cm", {"category": ("table",), "size_m": (0.8, 1.0)}),
        ("mug less than 1,000 g", {"category": ("mug",), "mass_kg": (0.0, 1.0)}),
        ("mug under .5 kg", {"category": ("mug",), "mass_kg": (0.0, 0.5)}),
        ("box 10cm - 200g", {"category": ("box",), "size_m": (0.08, 0.12), "mass_kg": (0.16, 0.24)}),
        ("", {}),
    ],
)
def test_requests_are_read(request_: str, meaning: dict[str, object]):
    found = read(request_)
    assert found.keys() == meaning.keys()
    for field, wanted in meaning.items():
        assert found[field] == (pytest.approx(wanted) if isinstance(wanted[0], float) else wanted)  # pyright: ignore[reportIndexIssue]


def test_the_last_noun_is_the_thing_so_a_mug_holder_is_no_mug():
    assert [(w.field, w.words) for w in parse_query("mug holder")] == [("text", "mug"), ("text", "holder")]


def asset(asset_id: str, category: str = "unknown", confidence: float = 0.0, **more) -> Facts:
    family = {"mug": "drinkware", "bowl": "kitchenware"}.get(category, "unknown")
    usual = {
        "outcome": "accepted", "possible": (), "roles": (), "materials": (), "colours": None,
        "extent_m": (0.08, 0.1, 0.12), "extent_confidence": 0.8, "mass_kg": 0.3, "mass_confidence": 0.3,
        "anchors": (), "tasks": (), "parts": (),
    }  # fmt: skip
    category_value = RatedValue(category, confidence, "test")
    return Facts(
        asset_id=asset_id, category=category_value, family=RatedValue(family, confidence, "test"), **(usual | more)
    )


RED = asset("red_mug", "mug", 0.9, colours={"red": 0.8, "white": 0.2}, anchors=(RatedValue("volume", 1.0, "volume_0"),))
BLUE = asset("blue_mug", "mug", 0.9, colours={"blue": 1.0}, anchors=(RatedValue("volume", 1.0, "volume_0"),))
PLAIN = asset("plain_mug", "mug", 0.6)
MAYBE = asset("maybe", possible=(("mug", 0.4), ("bowl", 0.3)))
BALL = asset("red_ball", "ball", 0.9, colours={"red": 1.0})
LIBRARY = (RED, BLUE, PLAIN, MAYBE, BALL)


def find(request: str, *flags: Criterion) -> SearchResult:
    def by_id(criterion: Criterion) -> dict[str, tuple[str, float, str]]:
        return {
            a.asset_id: ("names", 0.6, a.asset_id)
            for a in LIBRARY
            if set(criterion.values) & set(a.asset_id.split("_"))
        }

    return search(LIBRARY, [*parse_query(request), *flags], by_id)


def ids(result: SearchResult) -> list[str]:
    return [hit.asset.asset_id for hit in result.hits]


def test_a_hit_grants_every_wish_and_says_why():
    found = find("red mug I can pour from")
    assert ids(found) == ["red_mug"]
    assert {a.criterion.words: a.field for a in found.hits[0].matches} == {
        "mug": "semantics.category",
        "red": "appearance.colours",
        "pour from": "anchors",
    }
    assert found.near_misses[0].asset.asset_id == "blue_mug"
    assert [a.criterion.words for a in found.near_misses[0].misses] == ["red"]


def test_better_evidence_ranks_higher_and_a_mere_chance_last():
    assert ids(find("mug")) == ["blue_mug", "red_mug", "plain_mug", "maybe"]
    assert "maybe" not in ids(find("bowl"))  # Not the likeliest of its hypotheses.


def test_flags_ask_for_what_the_record_states():
    flag = Criterion("--category mug", "category", ("mug",), is_kind=True, stated=True)
    assert ids(find("", flag)) == ["blue_mug", "red_mug", "plain_mug"]


def test_a_thing_that_nobody_knows_matches_nothing_and_is_said():
    found = find("red unicorn")
    assert not found.hits
    assert [w.words for w in found.unmatched] == ["unicorn"]
    assert ids(find("teapot")) == []
    assert [w.words for w in find("teapot").unmatched] == ["teapot"]


def test_a_strange_word_beside_a_known_thing_is_said_and_ranks_only():
    found = find("nice red mug")
    assert ids(found) == ["red_mug"]
    assert [w.words for w in found.unmatched] == ["nice"]


@pytest.mark.parametrize(
    ("request_", "negated"),
    [
        ("not red mug", ["not red"]),
        ("mug without a handle", ["not handle"]),
        ("mug that is not red", ["not red"]),
        ("container other than a mug", ["not mug"]),
        ("tray without an opening", ["an opening"]),
        ("mug not for pouring", ["pouring"]),
        ("bowl without red or blue", ["not red", "not blue"]),
    ],
)
def test_what_is_denied_is_not_wished_for(request_: str, negated: list[str]):
    criteria = parse_query(request_)
    assert [w.words for w in criteria if w.negated] == negated
    assert [w.field for w in criteria if w.is_kind] in (["category"], ["family"])


def test_a_denied_kind_of_thing_is_a_kind_and_not_a_word():
    (criterion,) = parse_query("not a coffee mug")
    assert (criterion.field, criterion.values, criterion.negated) == ("category", ("mug",), True)
    assert ids(find("not a mug")) == ["red_ball"]  # What nobody knows may well be a mug.


def test_what_was_never_recorded_is_no_proof_that_it_is_not_there():
    assert ids(find("mug without a handle")) == []
    assert ids(find("mug not to cut with")) == []


def test_a_denied_colour_must_be_known_to_be_another():
    assert ids(find("mug that is not red")) == ["blue_mug"]


@pytest.mark.parametrize("request_", ["杯子", "the thing", "?!", "red 杯子"])
def test_a_request_that_says_nothing_known_finds_nothing(request_: str):
    found = find(request_)
    assert not found.hits
    assert found.unmatched


def test_an_affordance_counts_more_than_an_opening():
    pours = RED.model_copy(update={"asset_id": "pourer", "tasks": (RatedValue("spout pour", 0.9, "test"),)})
    found = search([RED, pours], parse_query("mug to pour from"), lambda _: {})
    assert ids(found) == ["pourer", "red_mug"]
    assert found.hits[0].matches[-1].field == "affordances"


def test_a_catalog_of_a_newer_version_is_refused(tmp_path: Path):
    catalog.rebuild(tmp_path)
    with sqlite3.connect(tmp_path / catalog.CATALOG) as db:
        db.execute(f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(InvalidInput) as refused:
        catalog.facts(tmp_path)
    assert refused.value.diagnostic.code == "asset/catalog-unreadable"


def test_a_catalog_whose_facts_are_of_another_shape_is_refused(tmp_path: Path):
    folder = tmp_path / "lib#1"  # A path is no part of an address.
    folder.mkdir()
    catalog.rebuild(folder)
    with sqlite3.connect(folder / catalog.CATALOG) as db:
        db.execute("INSERT INTO assets (key, asset_id) VALUES (1, 'a')")
        db.execute("INSERT INTO records (key, facts) VALUES (1, '{}')")
    with pytest.raises(InvalidInput) as refused:
        catalog.facts(folder)
    assert refused.value.diagnostic.code == "asset/catalog-unreadable"


@pytest.mark.parametrize(
    ("text", "request_", "negated", "found"),
    [
        ("чайник", "чайник", False, True),
        ("컵", "컵", False, True),
        (unicodedata.normalize("NFD", "컵"), "컵", False, True),
        ("candle", "can", False, True),
        ("candle", "can", True, False),
        ("can", "can", True, True),
    ],
)
def test_texts_are_found_in_any_script_and_denied_words_whole(
    text: str, request_: str, negated: bool, found: bool, tmp_path: Path
):
    catalog.rebuild(tmp_path)
    with sqlite3.connect(tmp_path / catalog.CATALOG) as db:
        db.execute("INSERT INTO assets (key, asset_id) VALUES (1, 'a')")
        db.execute("INSERT INTO words (rowid, names) VALUES (1, ?)", (facts._words([text]),))
    criterion = replace(parse_query(request_)[0], values=(request_,), negated=negated)
    assert bool(catalog.find_text(tmp_path, criterion)) is found


def test_each_word_is_indexed_once_and_unknown_is_no_word():
    assert facts._words(["widget_box", "Widget box", "unknown"]) == "widget box Widget"


def test_words_of_colours_are_known_and_other_words_are_not():
    assert [colour_by_name(term) for term in BASIC_TERMS] == list(BASIC_TERMS)
    assert [colour_by_name(w) for w in ("gray", "crimson", "navy", "violet")] == ["grey", "red", "blue", "purple"]
    assert colour_by_name("mug") is None


def test_pure_colours_have_the_names_everyone_gives_them():
    pure = [(0, 0, 0), (1, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0.21, 0.21, 0.21)]
    assert basic_terms(np.array(pure, float)) == ["black", "white", "red", "green", "blue", "yellow", "grey"]


def square(edge: float, material: int | None) -> Mesh:
    points = np.array([[0, 0, 0], [edge, 0, 0], [edge, edge, 0], [0, edge, 0]], float)
    return Mesh("square", points, np.array([[0, 1, 2], [0, 2, 3]], np.int32), material=material)


def model(meshes: tuple[Mesh, ...], materials: tuple[Material, ...]) -> Model:
    return Model(meshes, materials, (), (), default(1.0), default("z"))


def test_colours_count_by_area():
    red, blue = Material("a", (1.0, 0.0, 0.0)), Material("b", (0.0, 0.0, 1.0))
    assert surface_colours(model((square(1.0, 0), square(3.0, 1)), (red, blue))) == {"blue": 0.9, "red": 0.1}


def test_a_surface_of_no_stated_colour_has_none():
    assert surface_colours(model((square(1.0, None), square(1.0, 0)), (Material("m"),))) == {}
