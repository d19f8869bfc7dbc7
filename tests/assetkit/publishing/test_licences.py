"""What the licence on record permits, from the ways in which people and shops write it."""

from __future__ import annotations

import pytest

from assetkit.publishing.licences import judge_licence, known_licences, terms_of
from schemas.diagnostics import Location

NOTHING = frozenset[str]()


@pytest.mark.parametrize(
    ("text", "spdx"),
    [
        ("CC-BY-4.0", "CC-BY-4.0"),
        ("cc by 4.0", "CC-BY-4.0"),
        ("CC-BY-4.0 (http://creativecommons.org/licenses/by/4.0/)", "CC-BY-4.0"),
        ("Creative Commons Attribution 4.0 International", "CC-BY-4.0"),
        ("Creative Commons Attribution-NonCommercial-ShareAlike 4.0", "CC-BY-NC-SA-4.0"),
        ("CC Attribution-NoDerivs 3.0", "CC-BY-ND-3.0"),
        ("https://creativecommons.org/licenses/by-nc-nd/4.0/legalcode", "CC-BY-NC-ND-4.0"),
        ("https://creativecommons.org/publicdomain/zero/1.0/", "CC0-1.0"),
        ("CC0", "CC0-1.0"),
        ("mit", "MIT"),
        ("MIT License", "MIT"),
        ("The Apache License, Version 2.0", "Apache-2.0"),
        ("CC-BY", None),  # of which version?
        ("CC-BY-4.0 for the mesh", None),
        ("CC-BY-4.0 (not for companies)", None),
        ("CC-BY-4.0 but ask first, https://creativecommons.org/licenses/by/4.0/", None),
        ("CC-BY-NC-4.0 (https://creativecommons.org/licenses/by/4.0/)", None),
        ("SCEA Shared Source License 1.0", None),
        ("GPL-3.0", None),
    ],
)
def test_licences_are_known_by_id_name_and_address(text: str, spdx: str | None) -> None:
    terms = terms_of(text)
    assert (None if terms is None else terms.spdx) == spdx


@pytest.mark.parametrize(
    ("text", "allowed", "result"),
    [
        ("CC-BY-4.0", (), ["CC-BY-4.0"]),
        ("unknown", (), "asset/licence-missing"),
        ("  ", (), "asset/licence-missing"),
        ("NOASSERTION", (), "asset/licence-missing"),
        ("Research use only", (), "asset/licence-forbids-release"),
        ("Research use only", ("Research use only",), "asset/licence-forbids-release"),
        ("Copyright 2011 A. Smith. All rights reserved.", (), "asset/licence-forbids-release"),
        ("CC-BY-NC-4.0", (), "asset/licence-restricted"),
        ("CC-BY-NC-4.0", ("nc",), ["CC-BY-NC-4.0"]),
        ("CC-BY-NC-ND-4.0", ("nc",), "asset/licence-restricted"),
        ("CC-BY-NC-ND-4.0", ("nc", "nd"), ["CC-BY-NC-ND-4.0"]),
        ("SCEA Shared Source 1.0", (), "asset/licence-unrecognised"),
        ("SCEA Shared Source 1.0", ("SCEA Shared Source 1.0",), ["SCEA Shared Source 1.0"]),
        ("MIT AND CC-BY-4.0", (), ["MIT", "CC-BY-4.0"]),
        ("MIT AND CC-BY-NC-4.0", (), "asset/licence-restricted"),
        ("CC-BY-NC-4.0 OR CC-BY-SA-4.0", (), ["CC-BY-SA-4.0"]),
        ("CC-BY-NC-4.0 OR CC-BY-ND-4.0", (), "asset/licence-restricted"),
        ("MIT OR MIT AND CC-BY-4.0", (), "asset/licence-unrecognised"),
    ],
)
def test_a_licence_gives_terms_or_the_code_of_its_refusal(
    text: str, allowed: tuple[str, ...], result: list[str] | str
) -> None:
    terms, refused = judge_licence(text, frozenset(allowed), Location(file="mug"))
    if isinstance(result, list):
        assert ([each.spdx for each in terms], refused) == (result, ())
    else:
        assert (terms, {each.code for each in refused}) == ((), {result})


def test_terms_follow_from_the_letters_of_creative_commons_and_texts_that_must_go_along_are_there() -> None:
    from importlib.resources import files

    for spdx, terms in known_licences().items():
        letters = spdx.split("-")
        if letters[0] in ("CC", "CC0"):
            held = (terms.attribution, terms.share_alike, terms.non_commercial, terms.no_derivatives)
            assert held == tuple(letter in letters for letter in ("BY", "SA", "NC", "ND"))
        text = files("assetkit.publishing.texts") / f"{spdx}.md"
        assert text.is_file() == terms.needs_text
        assert not terms.needs_text or len(text.read_text()) > 500


def test_nothing_is_passed_on_by_an_allowance_of_another_licence() -> None:
    assert judge_licence("CC-BY-NC-4.0", frozenset({"CC-BY-4.0"}), Location()).refused
    assert judge_licence("CC-BY-4.0", NOTHING, Location()).terms
