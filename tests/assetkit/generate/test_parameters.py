"""Parameters: ranges with both bounds, nearest words, settings as text."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from assetkit.generate.parameters import (
    ParameterError,
    checked,
    choice,
    count,
    parameters_of,
    quantity,
    random_parameters,
    read_settings,
)


@dataclass(frozen=True)
class Lamp:
    bulbs: int = count(2, 1, 5, "bulbs")
    height_m: float = quantity(0.4, 0.2, 1.5, "m", "height")
    colour: str = choice("red", ("red", "green"), "colour")


def test_settings_replace_defaults() -> None:
    assert read_settings(Lamp, []) == Lamp()
    assert read_settings(Lamp, ["bulbs=3", " height_m = 0.5", "colour=green"]) == Lamp(3, 0.5, "green")
    assert isinstance(read_settings(Lamp, ["bulbs=3"]).bulbs, int)
    assert read_settings(Lamp, ["height_m=1"]).height_m == 1.0


@pytest.mark.parametrize("text", ["height_m=0.2", "height_m=1.5", "bulbs=1", "bulbs=5"])
def test_bounds_are_allowed(text: str) -> None:
    read_settings(Lamp, [text])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("height_m=2", "height_m must be 0.2 to 1.5 m; found 2"),
        ("height_m=0.19", "height_m must be 0.2 to 1.5 m; found 0.19"),
        ("height_m=nan", "height_m must be 0.2 to 1.5 m; found nan"),
        ("height_m=inf", "height_m must be 0.2 to 1.5 m; found inf"),
        ("height_m=tall", "height_m must be a number, 0.2 to 1.5 m; found 'tall'"),
        ("bulbs=2.5", "bulbs must be a whole number, 1 to 5; found 2.5"),
        ("bulbs=6", "bulbs must be a whole number, 1 to 5; found 6"),
        ("colour=gren", "colour has no choice 'gren'; did you mean green?"),
        ("hieght_m=1", "there is no parameter 'hieght_m'; did you mean height_m?"),
        ("zzz=1", "there is no parameter 'zzz'; known are bulbs, height_m, colour"),
        ("height_m", "'height_m' is no key=value, for instance bulbs=VALUE"),
    ],
)
def test_what_is_wrong_names_key_value_and_both_bounds(text: str, message: str) -> None:
    with pytest.raises(ParameterError) as refused:
        read_settings(Lamp, [text])
    assert str(refused.value) == message


def test_a_key_given_twice_is_refused() -> None:
    with pytest.raises(ParameterError, match="height_m is given twice"):
        read_settings(Lamp, ["height_m=1", "height_m=1"])


def test_values_from_python_are_held_to_the_same_ranges() -> None:
    with pytest.raises(ParameterError, match=r"0\.2 to 1\.5 m"):
        checked(Lamp(height_m=3.0))
    with pytest.raises(ParameterError, match="whole number"):
        checked(Lamp(bulbs=2.0))  # pyright: ignore[reportArgumentType]


def test_random_parameters_fill_their_ranges() -> None:
    rng = np.random.default_rng(0)
    drawn = [checked(random_parameters(Lamp, rng)) for _ in range(200)]
    assert {lamp.bulbs for lamp in drawn} == {1, 2, 3, 4, 5}
    assert {lamp.colour for lamp in drawn} == {"red", "green"}
    assert np.ptp([lamp.height_m for lamp in drawn]) > 1.2
    assert [p.unit for p in parameters_of(Lamp)] == ["", "m", ""]
