"""The reference page of effects is generated, and every effect says what a reader needs."""

import pytest

from cli.docs.effects import as_data
from sim.effects.effect import Effect
from sim.effects.library import EFFECT_NAMES, EFFECTS, RESERVED_NAMES


def test_names_are_unique_and_reserved_ones_are_free():
    assert len(set(EFFECT_NAMES)) == len(EFFECTS)
    assert not set(EFFECT_NAMES) & set(RESERVED_NAMES)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_an_effect_explains_itself(effect: Effect):
    data = as_data(effect)
    assert all(data[key] for key in ("formula", "source", "reveals", "acts", "kinds", "parameters"))
    assert all(p["unit"] and p["low"] < p["high"] for p in data["parameters"])
    assert {c["effect"] for c in data["confusable_with"]} <= set(EFFECT_NAMES) - {effect.name}
    assert all(c["experiment"] for c in data["confusable_with"])
