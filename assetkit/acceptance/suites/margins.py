"""How far a suite that passes keeps passing: at other engine steps, and at other values of friction and mass.

The four corners of the bounds of friction and mass come first: a suite that passes at all of them is taken to pass
between them. Else each quantity goes to both ends of its bounds while the other stays, and where the suite fails there
the value from which on it holds is found by bisection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import Conditions, Subject, Suite
from schemas.acceptance import Check, Corner, Margin, Quantity
from sim.port import Simulator


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
    corners = _corners(ranges, passes)
    if corners and all(corner.passed for corner in corners):
        margins = [Margin(quantity=q, low=low, high=high, bounds=(low, high)) for q, (_, (low, high)) in ranges.items()]
    else:
        margins = [_margin(quantity, *values, passes) for quantity, values in ranges.items()]
    return Variations(repeats, tuple(corners), tuple(margins))


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


def _corners(
    ranges: Mapping[Quantity, tuple[float, tuple[float, float]]], passes: Callable[[Conditions], bool]
) -> list[Corner]:
    """Where both have bounds."""
    if len(ranges) < 2:
        return []
    corners: list[Corner] = []
    for friction, mass_kg in product(ranges["friction"][1], ranges["mass_kg"][1]):
        passed = passes(Conditions("corner", friction=friction, mass_kg=mass_kg))
        corners.append(Corner(friction=friction, mass_kg=mass_kg, passed=passed))
    return corners
