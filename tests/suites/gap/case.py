"""What a case of the suite is, whatever kind of thing moved: a problem for the tool, and the truth kept beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from schemas.measurement import MeasurementSpec
from simgap.problem import Problem

Family = Literal["control", "single", "pair", "two", "outside"]


@dataclass(frozen=True)
class Case:
    """A problem that the tool sees, and what only the suite knows.

    family    control: nothing hidden; single, two: that many effects; pair: an effect with a double; outside: an effect
              that no file of the library describes.
    truth     hidden effects as `name@place`; empty for controls and outside.
    doubles   names that these very data cannot distinguish from a hidden one, itself included; empty where they can.
    checked   true values by effect name and parameter, where the library's parameter means the same number.
    size      `small`, `middle`, `large` by power; "" without a sized effect.
    ideal     share of the null refit's rms error that a perfect model would take away (1 - without / with the effect).
    chance    p-value of that perfect model over the training trials (`power.chance`); 0 where none is at hand.
    """

    name: str
    family: Family
    problem: Callable[[], Problem]
    spec: MeasurementSpec
    truth: tuple[str, ...] = ()
    doubles: frozenset[str] = frozenset()
    checked: Mapping[tuple[str, str], float] = field(default_factory=dict)
    size: str = ""
    ideal: float = 0.0
    chance: float = 0.0
