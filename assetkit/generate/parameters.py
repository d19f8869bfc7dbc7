"""Parameters of a generator: fields of a frozen data class with unit, allowed range and meaning; settings from text.

A generator declares them with `quantity`, `count` and `choice`; `checked` holds values to their ranges.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

_KEY = "parameter"  # under which a field's metadata holds its `Parameter`
P = TypeVar("P")
Value = float | int | str


class ParameterError(ValueError):
    """A parameter that does not exist, or a value outside its range; `key` is the parameter as given."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Parameter:
    """One parameter: a number within `low` and `high`, a whole one if `whole`, or one of `choices`."""

    name: str
    default: Value
    unit: str
    about: str
    low: float = -math.inf
    high: float = math.inf
    whole: bool = False
    choices: tuple[str, ...] = ()

    @property
    def allowed(self) -> str:
        """The range in words, with unit."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        return f"{self.low:g} to {self.high:g}{f' {self.unit}' if self.unit else ''}"


def quantity(default: float, low: float, high: float, unit: str, about: str) -> Any:
    """A field that holds a number in `unit` (SI), from `low` to `high`; "" for a pure number."""
    return _field(Parameter("", default, unit, about, low, high))


def count(default: int, low: int, high: int, about: str) -> Any:
    """A field that holds a whole number from `low` to `high`."""
    return _field(Parameter("", default, "", about, low, high, whole=True))


def choice(default: str, choices: Sequence[str], about: str) -> Any:
    """A field that holds one of `choices`."""
    return _field(Parameter("", default, "", about, choices=tuple(choices)))


def _field(parameter: Parameter) -> Any:
    return dataclasses.field(default=parameter.default, metadata={_KEY: parameter})


def parameters_of(declared: type) -> tuple[Parameter, ...]:
    """The parameters that a data class declares, in its order."""
    fields = dataclasses.fields(declared)
    return tuple(dataclasses.replace(f.metadata[_KEY], name=f.name) for f in fields if _KEY in f.metadata)


def checked(values: P) -> P:
    """The same parameters; raises ParameterError, with both bounds, for the first that is outside its range."""
    for parameter in parameters_of(type(values)):
        _require_allowed(parameter, getattr(values, parameter.name))
    return values


def read_settings(declared: type[P], settings: Sequence[str]) -> P:
    """Parameters with the defaults of `declared`, but for settings as `key=value`.

    Raises ParameterError for text without `=`, an unknown key, a key that is given twice, what is no number, and as
    `checked`.
    """
    known = {parameter.name: parameter for parameter in parameters_of(declared)}
    values: dict[str, Value] = {}
    for setting in settings:
        key, sign, text = (piece.strip() for piece in setting.partition("="))
        if not sign:
            raise ParameterError(key, f"'{setting}' is no key=value, for instance {next(iter(known))}=VALUE")
        if key not in known:
            raise ParameterError(key, f"there is no parameter '{key}'; {nearest(key, list(known))}")
        if key in values:
            raise ParameterError(key, f"{key} is given twice")
        values[key] = _value(known[key], text)
    return checked(declared(**values))


def nearest(word: str, known: Sequence[str]) -> str:
    """A hint: the known words most like `word`, or all of them."""
    near = difflib.get_close_matches(word, known, n=3)
    return f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known)}"


def random_parameters(declared: type[P], rng: np.random.Generator) -> P:
    """Parameters drawn evenly from their ranges."""
    return declared(**{p.name: _drawn(p, rng) for p in parameters_of(declared)})


def _drawn(parameter: Parameter, rng: np.random.Generator) -> Value:
    if parameter.choices:
        return str(rng.choice(parameter.choices))
    if parameter.whole:
        return int(rng.integers(int(parameter.low), int(parameter.high) + 1))
    return float(rng.uniform(parameter.low, parameter.high))


def _value(parameter: Parameter, text: str) -> Value:
    """The text as a value of the parameter's kind; ranges are checked later."""
    if parameter.choices:
        return text
    try:
        number = float(text)
    except ValueError:
        message = f"{parameter.name} must be a number, {parameter.allowed}; found '{text}'"
        raise ParameterError(parameter.name, message) from None
    return int(number) if parameter.whole and number.is_integer() else number


def _require_allowed(parameter: Parameter, value: Value) -> None:
    if parameter.choices:
        if value in parameter.choices:
            return
        hint = nearest(str(value), parameter.choices)
        raise ParameterError(parameter.name, f"{parameter.name} has no choice '{value}'; {hint}")
    what = "a whole number, " if parameter.whole else ""
    number = math.nan if isinstance(value, str) or (parameter.whole and not isinstance(value, int)) else value
    if not parameter.low <= number <= parameter.high:  # False for NaN.
        shown = f"{value:g}" if isinstance(value, float) else str(value)
        raise ParameterError(parameter.name, f"{parameter.name} must be {what}{parameter.allowed}; found {shown}")
