"""How far friction and mass of an object may be varied: the ranges over which its suites of acceptance passed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pydantic import BaseModel, ConfigDict

from schemas.acceptance import Corner, Quantity, SuiteSection
from schemas.asset import AssetRecord


class ExercisedRange(BaseModel):
    """The range of a quantity that acceptance exercised. `limited_by` names the suites that failed beyond its ends."""

    model_config = ConfigDict(frozen=True)

    quantity: Quantity
    value: float
    low: float
    high: float
    limited_by: tuple[str, ...] = ()

    def holds(self, value: float) -> bool:
        """Whether a value lies within, up to rounding."""
        return self.low * (1.0 - 1e-9) <= value <= self.high * (1.0 + 1e-9)


class Exercised(BaseModel):
    """The ranges of friction (dynamic, of the object's own surface) and mass over which every suite passed.

    Both may be drawn independently: no pair within lies at or beyond a corner of the bounds at which a suite failed.
    """

    model_config = ConfigDict(frozen=True)

    friction: ExercisedRange
    mass_kg: ExercisedRange


def exercised_ranges(record: AssetRecord) -> Exercised | None:
    """Those of a package around the friction and mass of its record; None where no suite was run."""
    if not record.acceptance.suites or not record.physics.contacts:
        return None
    friction = record.physics.contacts[0].value.dynamic_friction
    return exercised(record.acceptance.suites, friction=friction, mass_kg=record.physics.mass_kg.value)


def exercised(suites: Sequence[SuiteSection], *, friction: float, mass_kg: float) -> Exercised:
    """The ranges around the values on record that hold for all suites that passed.

    Each is where the margins of all suites overlap that were run at other values; without any it is the value alone.
    For every corner at which a suite failed, unless an end already keeps clear of it, the end that loses less (as a
    ratio) goes back to the value on record: single margins were tried with the other quantity at its value.
    """
    passed = [suite for suite in suites if suite.outcome == "passed"]
    ranges: dict[Quantity, ExercisedRange] = {
        "friction": _overlap(passed, "friction", friction),
        "mass_kg": _overlap(passed, "mass_kg", mass_kg),
    }
    for suite in passed:
        for corner in suite.corners:
            if not corner.passed:
                ranges |= _clear_of(corner, suite.name, ranges)
    return Exercised(friction=ranges["friction"], mass_kg=ranges["mass_kg"])


def _overlap(passed: Sequence[SuiteSection], quantity: Quantity, value: float) -> ExercisedRange:
    """Where the margins of all suites overlap; the value alone where no suite has one."""
    low, high, limited_by, varied = 0.0, math.inf, dict[str, None](), False
    for suite in passed:
        margin = next((m for m in suite.margins if m.quantity == quantity), None)
        if margin is None:
            continue
        varied = True
        low, high = max(low, margin.low), min(high, margin.high)
        if margin.statement:
            limited_by[suite.name] = None
    if not varied:
        low = high = value
    return ExercisedRange(quantity=quantity, value=value, low=low, high=high, limited_by=tuple(limited_by))


def _clear_of(corner: Corner, suite: str, ranges: dict[Quantity, ExercisedRange]) -> dict[Quantity, ExercisedRange]:
    """The range that changes so that no pair within both lies at or beyond a failed corner; {} if none has to."""
    candidates: list[tuple[float, ExercisedRange]] = []
    at_corner: dict[Quantity, float] = {"friction": corner.friction, "mass_kg": corner.mass_kg}
    for quantity, at in at_corner.items():
        old = ranges[quantity]
        is_low = at < old.value
        end = old.low if is_low else old.high
        if end == old.value:
            return {}  # Nothing is drawn on that side of the value.
        if end > at * (1.0 + 1e-9) if is_low else end < at * (1.0 - 1e-9):
            return {}  # A margin ends before the corner.
        change = {"low" if is_low else "high": old.value, "limited_by": tuple(dict.fromkeys((*old.limited_by, suite)))}
        candidates.append((abs(math.log(end / old.value)), old.model_copy(update=change)))
    _, changed = min(candidates, key=lambda candidate: candidate[0])
    return {changed.quantity: changed}
