"""Identifiers: valid as USD names, unique, reversible."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf

from schemas.identifiers import identifier, unique_identifiers


@given(st.lists(st.text(max_size=8), max_size=12))
def test_names_are_valid_unique_and_lead_back(names: list[str]) -> None:
    result = unique_identifiers(names, "mesh")
    assert list(result.values()) == names
    assert all(Sdf.Path.IsValidIdentifier(name) and name.isascii() for name in result)
    assert len({name.lower() for name in result}) == len(names)


@given(st.lists(st.from_regex(r"[A-Za-z][A-Za-z0-9]{0,6}", fullmatch=True), unique_by=str.lower, max_size=8))
def test_good_names_are_kept(names: list[str]) -> None:
    assert list(unique_identifiers(names, "mesh")) == names


def test_examples() -> None:
    assert list(unique_identifiers(["a", "a", "a_2", "A"], "mesh")) == ["a", "a_3", "a_2", "A_4"]
    assert identifier("größe 1", "mesh") == "gro_e_1"
    assert identifier("é", "mesh") == "e"
    assert identifier("机器", "mesh") == "mesh"
    assert identifier("3d", "mesh") == "_3d"
