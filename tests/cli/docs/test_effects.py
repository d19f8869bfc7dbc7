"""The reference page of effects is generated, and every effect says what a reader needs."""

import pytest

from cli.docs.effects import as_data, missing
from schemas.gap import EFFECT_NAMES
from sim.dynamics.hooks import Effect
from sim.effects.library import EFFECTS


def test_library_and_reserved_names_make_the_contract():
    assert {e.name for e in EFFECTS} | set(missing()) == set(EFFECT_NAMES)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_an_effect_explains_itself(effect: Effect):
    data = as_data(effect)
    assert all(data[key] for key in ("formula", "source", "reveals", "acts", "kinds", "parameters"))
    assert all(p["unit"] and p["low"] < p["high"] for p in data["parameters"])
    assert {c["effect"] for c in data["confusable_with"]} <= set(EFFECT_NAMES)
    assert all(c["experiment"] for c in data["confusable_with"])
