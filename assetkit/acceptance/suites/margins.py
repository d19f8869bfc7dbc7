"""How far a suite that passes keeps passing: at other engine steps, and at other values of friction and mass.

Each quantity goes to both ends of its bounds while the other stays; where the suite fails there, the value from which
on it holds is found by bisection. Corners of both are tried where both of their ends pass alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import Conditions, Subject, Suite
from schemas.asset import Check, Corner, Margin
from sim.port import Simulator

Quantity = Literal["friction", "mass_kg"]


@dataclass(frozen=True)
class Variations:
    """Outcomes under other conditions than the package's own."""

    repeats: tuple[Check, ...]
    corners: tuple[Corner, ...]
    margins: tuple[Margin, ...]


def variations(suite: Suite, subject: Subject, simulator: Simulator) -> Variations:
    """Of a suite that passes on the subject as it is."""

    def passes(conditions: Conditions) -> bool:
        return suite.run(subject, simulator, conditions).passes

    rates = [(rate, passes(Conditions(f"{rate:.0f} Hz", step_s=1.0 / rate))) for rate in POLICY.steps_hz]
    repeats = tuple(
        Check(name=f"passes_at_{rate:.0f}_hz", value=float(ok), bound=1.0, unit="", passed=ok) for rate, ok in rates
    )
    body = subject.body
    ranges: dict[Quantity, tuple[float, tuple[float, float]]] = {}
    if subject.friction_bounds is not None:
        ranges["friction"] = body.contact.dynamic_friction, subject.friction_bounds
    if subject.mass_bounds_kg is not None:
        ranges["mass_kg"] = body.mass.mass_kg, subject.mass_bounds_kg
    margins = tuple(_margin(quantity, *values, passes) for quantity, values in ranges.items())
    corners = _corners(margins[0], margins[1], passes) if len(margins) == 2 else []
    return Variations(repeats, tuple(corners), margins)


def _margin(
    quantity: Quantity, value: float, bounds: tuple[float, float], passes: Callable[[Conditions], bool]
) -> Margin:
    """The range around a value that passes, to within a `POLICY.margin_share` of it."""
    ends: list[float] = []
    for bound in bounds:
        if bound == value or passes(_at(quantity, bound)):
            ends.append(bound)
            continue
        holds, fails = value, bound
        while abs(math.log(fails / holds)) > math.log1p(POLICY.margin_share):
            middle = math.sqrt(holds * fails)
            holds, fails = (middle, fails) if passes(_at(quantity, middle)) else (holds, middle)
        ends.append(holds)
    return Margin(quantity=quantity, low=min(ends[0], value), high=max(ends[1], value), bounds=bounds)


def _at(quantity: Quantity, value: float) -> Conditions:
    name = f"{quantity} {value:.3g}"
    return Conditions(name, friction=value) if quantity == "friction" else Conditions(name, mass_kg=value)


def _corners(friction: Margin, mass: Margin, passes: Callable[[Conditions], bool]) -> list[Corner]:
    corners: list[Corner] = []
    for f, f_passes in zip(friction.bounds, _ends_pass(friction), strict=True):
        for m, m_passes in zip(mass.bounds, _ends_pass(mass), strict=True):
            both = f_passes and m_passes and passes(Conditions("corner", friction=f, mass_kg=m))
            corners.append(Corner(friction=f, mass_kg=m, passed=both))
    return corners


def _ends_pass(margin: Margin) -> tuple[bool, bool]:
    return margin.low <= margin.bounds[0], margin.high >= margin.bounds[1]
