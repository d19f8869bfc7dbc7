"""Texts of findings can be printed and stored anywhere, whatever names the files of others hold."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.diagnostics import Label, Location, finding, printable

ANY_TEXT = st.text(st.characters())  # lone surrogates as well


@given(ANY_TEXT)
def test_no_text_acts_on_a_terminal_breaks_a_line_or_cannot_be_stored(text: str):
    shown = printable(text)
    shown.encode("utf-8")
    assert len(shown.splitlines()) <= 1
    assert "\x1b" not in shown
    assert printable(shown) == shown


@given(st.text(st.characters(categories=["L", "N", "P", "S", "Zs"])))
def test_printable_text_stays_as_it_is(text: str):
    assert printable(text) == text


@pytest.mark.parametrize("name", ["\x1b[31mred", "new\nline", "\udcff", "\u202egnp", "\x9b1m"])
def test_every_text_of_a_finding_is_printable(name: str):
    where = Location(file=name, prim=name, mesh=name)
    diagnostic = finding(
        "asset/path-escape", name, where=where, value=name, bound=name, labels=(Label(where=where, text=name),)
    )
    assert name not in json.dumps(json.loads(diagnostic.model_dump_json()), ensure_ascii=False)
    assert str(diagnostic.where).isprintable()
